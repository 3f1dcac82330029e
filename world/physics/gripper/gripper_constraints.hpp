#pragma once

#include <array>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/engine/engine.hpp"
#include "world/physics/gripper/finger_drive.hpp"

namespace aprsim::physics {

/// Geometry of a gripper's joints, and the stiffness of its mount. Bodies in this order: palm, two
/// fingers, lever (linkage only).
struct GripperJoints {
  bool fingers = true;  ///< else the palm is all there is
  bool linkage = false;
  double closed_travel_m = 0;           ///< of the closed end stop
  double mount_erp = 0, mount_cfm = 0;  ///< of the palm on the carriage
  /// In the palm's frame: the open fingers' centres, the lever's pivot.
  std::array<Eigen::Vector3d, 2> rail;
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
  /// The rods' ends in the fingers' and the lever's frames.
  std::array<Eigen::Vector3d, 2> rod_on_finger, rod_on_lever;

  [[nodiscard]] std::size_t body_count() const { return !fingers ? 1 : linkage ? 4 : 3; }
};

/// Forces of a gripper's joints in the last step, which warm-start the next one.
struct GripperForces {
  std::array<JointForce, 6> mount;
  std::array<std::array<JointForce, 5>, 2> rail;
  std::array<JointForce, 2> piston, open_stop, closed_stop;
  std::array<JointForce, 7> linkage;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [mount, rail, piston, open_stop, closed_stop, linkage] = self;
    io(mount, rail, piston, open_stop, closed_stop, linkage);
  }
};

/// The gripper's joints in an engine.
class GripperConstraints {
 public:
  static constexpr double kRodLength = 0.05;  // [m]

  GripperConstraints(const GripperJoints& joints, std::span<RigidBody> bodies, RigidBody& carriage)
      : joints_(joints), bodies_(bodies), carriage_(carriage) {}

  /// Adds bodies, joints, pistons and end stops at the bodies' present poses.
  void add_to(Engine& engine, const std::array<FingerMotion, 2>& motion,
              const std::array<FingerDrive, 2>& drives, GripperForces& forces) const;

 private:
  static constexpr double kStiffCfm = 1e-9;  // [m/(s N)]

  void add_mount(Engine& engine, GripperForces& forces) const;
  void add_finger(Engine& engine, std::size_t i, const FingerMotion& motion,
                  const FingerDrive& drive, GripperForces& forces) const;
  void add_linkage(Engine& engine, GripperForces& forces) const;

  [[nodiscard]] RigidBody& palm() const { return bodies_[0]; }
  [[nodiscard]] RigidBody& finger(std::size_t i) const { return bodies_[i + 1]; }
  [[nodiscard]] RigidBody& lever() const { return bodies_[3]; }

  const GripperJoints& joints_;
  std::span<RigidBody> bodies_;
  RigidBody& carriage_;
};

}  // namespace aprsim::physics
