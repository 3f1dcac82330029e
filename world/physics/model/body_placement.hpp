#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/model/body_pose.hpp"
#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

/// Sets poses and velocities of free bodies between two steps, and removes bodies from the cell.
/// Affected bodies are awake and unmerged afterwards.
class BodyPlacement {
 public:
  explicit BodyPlacement(PhysicsModel& model);

  /// Sets the velocity of a body, that of its centre of mass. It wakes and is unmerged.
  void set_velocity(int body, const Eigen::Vector3d& v_com_W, const Eigen::Vector3d& omega_W);
  /// Adds an impulse [Ns] at the centre of mass and an angular impulse [Nms]. It wakes and is
  /// unmerged.
  void add_impulse(int body, const Eigen::Vector3d& impulse_W, const Eigen::Vector3d& angular_W);
  /// Whether the body is decoupled_from_belt: the belt then does not carry it.
  void set_decoupled_from_belt(int body, bool decoupled_from_belt);
  /// Places bodies at rest. All are raised by the same height, such that no bounding box overlaps
  /// one of another body. Everything wakes. Lost bodies stay lost.
  void place(std::span<const BodyPose> poses);
  /// Removes a body from the cell: it is lost in this step.
  void remove(int body, std::uint64_t step);
  /// Marks bodies that have fallen below everything, or whose motion has diverged, as lost in this
  /// step.
  void lose_bodies(std::uint64_t step);

 private:
  void wake(int body);
  void wake_all();
  [[nodiscard]] std::vector<Aabb> obstacles(std::span<const BodyPose> placed) const;
  [[nodiscard]] double clearance_m(std::span<const BodyPose> placed) const;

  PhysicsModel& model_;
  std::vector<int> losing_;
};

}  // namespace aprsim::physics
