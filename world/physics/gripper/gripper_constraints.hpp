#pragma once

#include <array>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/bodies/ode_handles.hpp"
#include "world/physics/constraint/constraint_system.hpp"
#include "world/physics/gripper/finger_drive.hpp"

namespace aprsim::physics {

/// Where a gripper's joints are on its bodies, and how stiff its mount is.
struct GripperJoints {
  std::array<dBodyID, 4> bodies{};  ///< palm, two fingers, lever (linkage only)
  dBodyID carriage = nullptr;
  bool fingers = true;  ///< else the palm is all there is
  bool linkage = false;
  double closed_travel_m = 0;           ///< of the closed end stop
  double mount_erp = 0, mount_cfm = 0;  ///< of the palm on the carriage
  /// In the palm's frame: the open fingers' centres, the lever's pivot.
  std::array<Eigen::Vector3d, 2> rail;
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
  /// The rods' ends in the fingers' and the lever's frames.
  std::array<Eigen::Vector3d, 2> rod_on_finger, rod_on_lever;

  [[nodiscard]] std::span<const dBodyID> moved() const {
    return {bodies.data(), !fingers ? 1u : linkage ? 4u : 3u};
  }
};

/// Forces of a gripper's joints in the last step, where the search of the next one begins.
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
  // Soft enough that piston, stop and linkage, which hold the same finger, stay well conditioned:
  // 60 N move it by less than 0.1 mm/s against the piston, and not at all against the stop.
  static constexpr double kPistonCfm = 1e-6, kStopCfm = 1e-7;
  static constexpr double kRodLength = 0.05;  // [m]

  GripperConstraints(const GripperJoints& joints, double step_s)
      : joints_(joints), step_s_(step_s) {}

  /// Adds bodies, joints, pistons and end stops at the bodies' present poses.
  void add_to(ConstraintSystem& system, const std::array<FingerMotion, 2>& motion,
              const std::array<FingerDrive, 2>& drives, GripperForces& forces) const;

 private:
  void add_mount(ConstraintSystem& system, GripperForces& forces) const;
  void add_slider(ConstraintSystem& system, std::size_t i, GripperForces& forces) const;
  void add_drive(ConstraintSystem& system, std::size_t i, const FingerMotion& motion,
                 const FingerDrive& drive, GripperForces& forces) const;
  void add_linkage(ConstraintSystem& system, GripperForces& forces) const;

  const GripperJoints& joints_;
  double step_s_;
};

}  // namespace aprsim::physics
