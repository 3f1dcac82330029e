#include "world/physics/constraint/joint_rows.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

// ERP removes a share of a position error in each step (Baumgarte 1972 stabilisation).
constexpr double kRowErp = 0.2, kRowCfm = 1e-9;
// Soft enough that piston, stop and linkage, which hold the same finger, stay well conditioned:
// 60 N move it by less than 0.1 mm/s against the piston, and not at all against the stop.
constexpr double kMotorCfm = 1e-6, kStopCfm = 1e-7;

/// The small rotation in world that takes axes `from` to axes `to`: half the sum of cross products.
Vector3d turn_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  return 0.5 * (from.col(0).cross(to.col(0)) + from.col(1).cross(to.col(1)) +
                from.col(2).cross(to.col(2)));
}

/// A force between two bodies. It acts halfway between their centres, so that it leaves no net
/// torque.
struct SliderForce {
  RigidBody& a;
  RigidBody& b;
  Vector3d lever = 0.5 * (b.p_W() - a.p_W());
  [[nodiscard]] RowSide on_a(const Vector3d& d) const { return RowSide::of_point(a, d, lever); }
  [[nodiscard]] RowSide on_b(const Vector3d& d) const { return RowSide::of_point(b, -d, -lever); }
};

/// No rotation, and translation along y only.
void add_rail(const SliderJoint& joint, const SliderForce& force, ConstraintSystem& system) {
  const double k = kRowErp / system.step_s();
  const RigidBody& a = joint.a;
  const RigidBody& b = joint.b;
  const Vector3d turn = turn_between(a.R_WB(), b.R_WB());
  for (int column = 0; column < 3; ++column) {
    const Vector3d axis = b.R_WB().col(column);
    system.add_joint_row(RowSide::of_turn(joint.a, axis), RowSide::of_turn(joint.b, -axis),
                         k * axis.dot(turn), kRowCfm, joint.rail[static_cast<std::size_t>(column)]);
  }
  const Vector3d off = b.p_W() + b.R_WB() * joint.p_BA - a.p_W();
  for (const int column : {0, 2}) {
    const Vector3d d = a.R_WB().col(column);
    system.add_joint_row(force.on_a(d), force.on_b(d), k * d.dot(off), kRowCfm,
                         joint.rail[column == 0 ? 3 : 4]);
  }
}

}  // namespace

/// Six bilateral rows: translation, then rotation.
void add_rows(const FixedJoint& joint, ConstraintSystem& system) {
  RigidBody &a = joint.a, &b = joint.b;
  const Eigen::Matrix3d &R_a = a.R_WB(), &R_b = b.R_WB();
  const Eigen::Matrix3d R_a0 = joint.X_WA.linear(), R_b0 = joint.X_WB.linear();
  const Vector3d apart = b.p_W() - a.p_W();
  const Vector3d joined = joint.X_WB.translation() - joint.X_WA.translation();
  // Errors against the relative pose when joined: of position, and the small rotation between them.
  const Vector3d off = apart - R_a * (R_a0.transpose() * joined);
  const Eigen::Matrix3d R_a_wanted = R_b * R_b0.transpose() * R_a0;
  const Vector3d turn = turn_between(R_a, R_a_wanted);
  const double k_turn = kRowErp / system.step_s();
  const double k = joint.spring ? joint.spring->erp / system.step_s() : k_turn;
  const double cfm = joint.spring ? joint.spring->cfm : joint.compliance;
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = joint.R_WJ.col(i);
    system.add_joint_row(RowSide::of_point(a, axis, joint.lever_W),
                         RowSide::of_point(b, -axis, Vector3d::Zero()), k * axis.dot(off), cfm,
                         joint.forces[static_cast<std::size_t>(i)]);
  }
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = joint.R_WJ.col(i);
    system.add_joint_row(RowSide::of_turn(a, axis), RowSide::of_turn(b, -axis),
                         k_turn * axis.dot(turn), joint.compliance,
                         joint.forces[static_cast<std::size_t>(i) + 3]);
  }
}

/// The rail, then the motor as a row of limited force, and the stop that the body is at.
void add_rows(const SliderJoint& joint, ConstraintSystem& system) {
  constexpr double kUnbounded = ContactProblem::kNoBound;
  const double k = kRowErp / system.step_s();
  const SliderForce force{joint.a, joint.b};
  add_rail(joint, force, system);
  const Vector3d along = joint.sign * joint.a.R_WB().col(1);
  // The body follows the wanted speed as long as the force suffices. At the bound the force is
  // constant, as that of a piston.
  if (joint.force_n > 0) {
    system.add_row(force.on_a(along), force.on_b(along), joint.speed_m_s, kMotorCfm, -joint.force_n,
                   joint.force_n, joint.motor);
  }
  if (joint.travel_m <= 0) {
    system.add_row(force.on_a(along), force.on_b(along), -k * joint.travel_m, kStopCfm, 0,
                   kUnbounded, joint.lower_stop);
  } else if (joint.travel_m >= joint.end_m) {
    system.add_row(force.on_a(-along), force.on_b(-along), k * (joint.travel_m - joint.end_m),
                   kStopCfm, 0, kUnbounded, joint.upper_stop);
  }
}

/// Three rows hold the pivot, two keep both axes parallel; the rotation about the axis is free.
void add_rows(const HingeJoint& joint, ConstraintSystem& system) {
  const double k = kRowErp / system.step_s();
  RigidBody &a = joint.a, &b = joint.b;
  const Vector3d arm = b.R_WB() * joint.p_BA, off = b.p_W() + arm - a.p_W();
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = b.R_WB().col(i);
    system.add_joint_row(RowSide::of_point(a, axis, Vector3d::Zero()),
                         RowSide::of_point(b, -axis, arm), k * axis.dot(off), kRowCfm,
                         joint.forces[static_cast<std::size_t>(i)]);
  }
  const Vector3d tilt = a.R_WB().col(2).cross(b.R_WB().col(2));
  for (const int column : {0, 1}) {
    const Vector3d d = b.R_WB().col(column);
    system.add_joint_row(RowSide::of_turn(a, d), RowSide::of_turn(b, -d), k * d.dot(tilt), kRowCfm,
                         joint.forces[column == 0 ? 3 : 4]);
  }
}

void add_rows(const RodJoint& joint, ConstraintSystem& system) {
  RigidBody &a = joint.a, &b = joint.b;
  const Vector3d on_a = a.R_WB() * joint.p_A, on_b = b.R_WB() * joint.p_B;
  const Vector3d rod = a.p_W() + on_a - b.p_W() - on_b;
  const Vector3d d = rod.normalized();
  system.add_joint_row(RowSide::of_point(a, d, on_a), RowSide::of_point(b, -d, on_b),
                       kRowErp / system.step_s() * (joint.length_m - rod.norm()), kRowCfm,
                       joint.force);
}

}  // namespace aprsim::physics
