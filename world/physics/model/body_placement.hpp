#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/model/body_pose.hpp"
#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

/// Moves free bodies other than by forces, between two steps: puts them down, removes them from the
/// cell, sets their velocities. Bodies that slept or were merged are on their own afterwards.
class BodyPlacement {
 public:
  explicit BodyPlacement(PhysicsModel& model);

  /// Sets the velocity of a body, that of its centre of mass. It wakes and leaves what it is merged
  /// with.
  void set_velocity(int body, const Eigen::Vector3d& v_com_W, const Eigen::Vector3d& omega_W);
  /// From now on: whether the belt leaves the body behind.
  void set_jammed(int body, bool jammed);
  /// Puts bodies down at rest, all as high above the poses given as the highest that needs it:
  /// clear of all other things, as far as their boxes tell. Everything wakes. Lost bodies stay so.
  void put(std::span<const BodyPose> poses);
  /// Takes a body out of the cell, lost in this step.
  void take_away(int body, std::uint64_t step);
  /// Bodies that nothing can catch any more are lost in this step.
  void lose_fallen(std::uint64_t step);

 private:
  void wake(int body);
  void wake_all();
  [[nodiscard]] std::vector<Aabb> obstacles(std::span<const BodyPose> put) const;
  [[nodiscard]] double clearance_m(std::span<const BodyPose> put) const;

  PhysicsModel& model_;
  std::vector<int> fallen_;
};

}  // namespace aprsim::physics
