#include "world/physics/gripper/gripper_constraints.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

constexpr double kRowErp = 0.2, kRowCfm = 1e-9;
// Soft enough that piston, stop and linkage, which hold the same finger, stay well conditioned:
// 60 N move it by less than 0.1 mm/s against the piston, and not at all against the stop.
constexpr double kPistonCfm = 1e-6, kStopCfm = 1e-7;

/// The small rotation in world that takes axes `from` to axes `to`.
Vector3d turn_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  return 0.5 * (from.col(0).cross(to.col(0)) + from.col(1).cross(to.col(1)) +
                from.col(2).cross(to.col(2)));
}

/// A force between finger and palm. It acts halfway between their centres, so that it leaves no net
/// torque.
struct FingerForce {
  RigidBody& finger;
  RigidBody& palm;
  Vector3d lever = 0.5 * (palm.p_W() - finger.p_W());
  [[nodiscard]] RowSide on_finger(const Vector3d& d) const {
    return RowSide::of_point(finger, d, lever);
  }
  [[nodiscard]] RowSide on_palm(const Vector3d& d) const {
    return RowSide::of_point(palm, -d, -lever);
  }
};

}  // namespace

void GripperConstraints::add_to(ConstraintSystem& system, const std::array<FingerMotion, 2>& motion,
                                const std::array<FingerDrive, 2>& drives,
                                GripperForces& forces) const {
  // The order of rows is fixed: mount, rails, pistons, stops, linkage. Warm starts are stored in
  // the same order.
  for (RigidBody& body : bodies_) system.add_body(body);
  add_mount(system, forces);
  for (std::size_t i = 0; joints_.fingers && i < 2; ++i) {
    add_slider(system, i, forces);
    add_drive(system, i, motion[i], drives[i], forces);
  }
  if (joints_.linkage) add_linkage(system, forces);
}

// Axes of rows are those of the palm: the forces of a rotating hand are then constant, which makes
// those of the last step good warm starts.

/// The palm fixed to the carriage: compliant in translation, stiff in rotation.
void GripperConstraints::add_mount(ConstraintSystem& system, GripperForces& forces) const {
  const Vector3d off = carriage_.p_W() - palm().p_W();
  const Vector3d turn = turn_between(palm().R_WB(), carriage_.R_WB());
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = palm().R_WB().col(i);
    const auto k = static_cast<std::size_t>(i);
    system.add_joint_row(RowSide::of_point(palm(), axis, Vector3d::Zero()),
                         RowSide::of_point(carriage_, -axis, Vector3d::Zero()),
                         joints_.mount_erp / step_s_ * axis.dot(off), joints_.mount_cfm,
                         forces.mount[k]);
    system.add_joint_row(RowSide::of_turn(palm(), axis), RowSide::of_turn(carriage_, -axis),
                         kRowErp / step_s_ * axis.dot(turn), kRowCfm, forces.mount[k + 3]);
  }
}

/// A finger on its rail: no rotation, and translation along the closing direction only.
void GripperConstraints::add_slider(ConstraintSystem& system, std::size_t i,
                                    GripperForces& forces) const {
  const double k = kRowErp / step_s_;
  RigidBody& sliding = finger(i);
  const Vector3d turn = turn_between(sliding.R_WB(), palm().R_WB());
  for (int column = 0; column < 3; ++column) {
    const Vector3d axis = palm().R_WB().col(column);
    system.add_joint_row(RowSide::of_turn(sliding, axis), RowSide::of_turn(palm(), -axis),
                         k * axis.dot(turn), kRowCfm,
                         forces.rail[i][static_cast<std::size_t>(column)]);
  }
  const FingerForce force{sliding, palm()};
  const Vector3d off = palm().p_W() + palm().R_WB() * joints_.rail[i] - sliding.p_W();
  for (const int column : {0, 2}) {
    const Vector3d d = sliding.R_WB().col(column);
    system.add_joint_row(force.on_finger(d), force.on_palm(d), k * d.dot(off), kRowCfm,
                         forces.rail[i][column == 0 ? 3 : 4]);
  }
}

/// The piston as a motor of limited force, and the end stop that the finger is at.
void GripperConstraints::add_drive(ConstraintSystem& system, std::size_t i,
                                   const FingerMotion& motion, const FingerDrive& drive,
                                   GripperForces& forces) const {
  constexpr double kUnbounded = ContactProblem::kNoBound;
  const double k = kRowErp / step_s_;
  const FingerForce force{finger(i), palm()};
  const Vector3d closing = (i == 0 ? -1.0 : 1.0) * finger(i).R_WB().col(1);
  // A motor row: the finger follows the wanted speed as long as the force suffices. At the bound
  // the force is constant, as that of a piston.
  if (drive.piston_n > 0) {
    system.add_row(force.on_finger(closing), force.on_palm(closing), drive.speed_m_s, kPistonCfm,
                   -drive.piston_n, drive.piston_n, forces.piston[i]);
  }
  if (motion.travel_m <= 0) {
    system.add_row(force.on_finger(closing), force.on_palm(closing), -k * motion.travel_m, kStopCfm,
                   0, kUnbounded, forces.open_stop[i]);
  } else if (motion.travel_m >= joints_.closed_travel_m) {
    system.add_row(force.on_finger(-closing), force.on_palm(-closing),
                   k * (motion.travel_m - joints_.closed_travel_m), kStopCfm, 0, kUnbounded,
                   forces.closed_stop[i]);
  }
}

/// The lever on a hinge in the palm, and a rod of constant length from each of its ends to a
/// finger.
void GripperConstraints::add_linkage(ConstraintSystem& system, GripperForces& forces) const {
  const double k = kRowErp / step_s_;
  const Vector3d arm = palm().R_WB() * joints_.pivot, off = palm().p_W() + arm - lever().p_W();
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = palm().R_WB().col(i);
    system.add_joint_row(RowSide::of_point(lever(), axis, Vector3d::Zero()),
                         RowSide::of_point(palm(), -axis, arm), k * axis.dot(off), kRowCfm,
                         forces.linkage[static_cast<std::size_t>(i)]);
  }
  // A hinge: three rows hold the pivot, two keep both axes parallel; the rotation about the axis is
  // free.
  const Vector3d tilt = lever().R_WB().col(2).cross(palm().R_WB().col(2));
  for (const int column : {0, 1}) {
    const Vector3d d = palm().R_WB().col(column);
    system.add_joint_row(RowSide::of_turn(lever(), d), RowSide::of_turn(palm(), -d),
                         k * d.dot(tilt), kRowCfm, forces.linkage[column == 0 ? 3 : 4]);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const Vector3d on_finger = finger(i).R_WB() * joints_.rod_on_finger[i];
    const Vector3d on_lever = lever().R_WB() * joints_.rod_on_lever[i];
    const Vector3d rod = finger(i).p_W() + on_finger - lever().p_W() - on_lever;
    const Vector3d d = rod.normalized();
    system.add_joint_row(RowSide::of_point(finger(i), d, on_finger),
                         RowSide::of_point(lever(), -d, on_lever), k * (kRodLength - rod.norm()),
                         kRowCfm, forces.linkage[5 + i]);
  }
}

}  // namespace aprsim::physics
