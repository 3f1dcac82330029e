#pragma once

#include <array>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/constraint/constraint_system.hpp"
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
  std::array<RowForce, 6> mount;
  std::array<std::array<RowForce, 5>, 2> rail;
  std::array<RowForce, 2> piston, open_stop, closed_stop;
  std::array<RowForce, 7> linkage;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [mount, rail, piston, open_stop, closed_stop, linkage] = self;
    io(mount, rail, piston, open_stop, closed_stop, linkage);
  }
};

/// The gripper's joints as rows of a ConstraintSystem.
class GripperConstraints {
 public:
  static constexpr double kRodLength = 0.05;  // [m]

  GripperConstraints(const GripperJoints& joints, std::span<RigidBody> bodies, RigidBody& carriage,
                     double step_s)
      : joints_(joints), bodies_(bodies), carriage_(carriage), step_s_(step_s) {}

  /// Adds bodies, joints, pistons and end stops at the bodies' present poses.
  void add_to(ConstraintSystem& system, const std::array<FingerMotion, 2>& motion,
              const std::array<FingerDrive, 2>& drives, GripperForces& forces) const;

 private:
  void add_mount(ConstraintSystem& system, GripperForces& forces) const;
  void add_slider(ConstraintSystem& system, std::size_t i, GripperForces& forces) const;
  void add_drive(ConstraintSystem& system, std::size_t i, const FingerMotion& motion,
                 const FingerDrive& drive, GripperForces& forces) const;
  void add_linkage(ConstraintSystem& system, GripperForces& forces) const;

  [[nodiscard]] RigidBody& palm() const { return bodies_[0]; }
  [[nodiscard]] RigidBody& finger(std::size_t i) const { return bodies_[i + 1]; }
  [[nodiscard]] RigidBody& lever() const { return bodies_[3]; }

  const GripperJoints& joints_;
  std::span<RigidBody> bodies_;
  RigidBody& carriage_;
  double step_s_;
};

}  // namespace aprsim::physics
