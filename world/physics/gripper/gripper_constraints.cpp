#include <limits>

#include "world/physics/constraint/constraint_system.hpp"
#include "world/physics/gripper/gripper_mechanism.hpp"

// The gripper's joints as rows of a system: the same equations as those of its ODE joints, save
// that a driven finger at its end stop has a row for each.
namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

constexpr double kRowErp = 0.2, kRowCfm = 1e-9;

/// Position and orientation of an ODE body.
struct Place {
  explicit Place(dBodyID body)
      : p(ode::vector(dBodyGetPosition(body))), R(ode::matrix(dBodyGetRotation(body))) {}
  Vector3d p;
  Eigen::Matrix3d R;
};

/// The small turn in world that takes axes `from` to axes `to`.
Vector3d turn_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  return 0.5 * (from.col(0).cross(to.col(0)) + from.col(1).cross(to.col(1)) +
                from.col(2).cross(to.col(2)));
}

}  // namespace

void GripperMechanism::add_to(ConstraintSystem& system) {
  place_carriage();
  apply_forces();
  for (dBodyID body : bodies()) system.add_body(body);
  add_mount(system);
  for (std::size_t i = 0; i < 2; ++i) add_slider(system, i);
  if (settings_.law == scene::GripperLaw::kLinkage) add_linkage(system);
}

void GripperMechanism::add_mount(ConstraintSystem& system) const {
  const Place palm(bodies_[0]), carriage(carriage_.get());
  const double erp = dJointGetFixedParam(mount_.get(), dParamERP);
  const double cfm = dJointGetFixedParam(mount_.get(), dParamCFM);
  const Vector3d off = carriage.p - palm.p, turn = turn_between(palm.R, carriage.R);
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = Vector3d::Unit(i);
    system.add_tie({bodies_[0], axis, Vector3d::Zero()}, {carriage_.get(), -axis, Vector3d::Zero()},
                   erp / step_s_ * off[i], cfm);
    system.add_tie({bodies_[0], Vector3d::Zero(), axis}, {carriage_.get(), Vector3d::Zero(), -axis},
                   kRowErp / step_s_ * turn[i], kRowCfm);
  }
}

void GripperMechanism::add_slider(ConstraintSystem& system, std::size_t i) const {
  const double k = kRowErp / step_s_;
  dBodyID finger_body = bodies_[i + 1], palm_body = bodies_[0];
  const Place finger(finger_body), palm(palm_body);
  const Vector3d turn = turn_between(finger.R, palm.R);
  for (int axis = 0; axis < 3; ++axis) {
    system.add_tie({finger_body, Vector3d::Zero(), Vector3d::Unit(axis)},
                   {palm_body, Vector3d::Zero(), -Vector3d::Unit(axis)}, k * turn[axis], kRowCfm);
  }
  // Forces between the two act halfway between their centres, so that they leave no net torque.
  const Vector3d lever = 0.5 * (palm.p - finger.p);
  const Vector3d off = palm.p + palm.R * rail_[i] - finger.p;
  const auto on_finger = [&](const Vector3d& d) { return RowSide{finger_body, d, lever.cross(d)}; };
  const auto on_palm = [&](const Vector3d& d) { return RowSide{palm_body, -d, lever.cross(d)}; };
  for (const int column : {0, 2}) {
    const Vector3d d = finger.R.col(column);
    system.add_tie(on_finger(d), on_palm(d), k * d.dot(off), kRowCfm);
  }
  const Vector3d closing = (i == 0 ? -1.0 : 1.0) * finger.R.col(1);
  const FingerDrive& drive = now_.drives[i];
  const double travel = now_.motion[i].travel_m;
  constexpr double kUnbounded = std::numeric_limits<double>::infinity();
  if (drive.piston_n > 0) {
    system.add_limited(on_finger(closing), on_palm(closing), drive.speed_m_s, kPistonCfm,
                       -drive.piston_n, drive.piston_n);
  }
  if (travel <= 0) {
    system.add_limited(on_finger(closing), on_palm(closing), -k * travel, kStopCfm, 0, kUnbounded);
  } else if (travel >= end_m_) {
    system.add_limited(on_finger(-closing), on_palm(-closing), k * (travel - end_m_), kStopCfm, 0,
                       kUnbounded);
  }
}

void GripperMechanism::add_linkage(ConstraintSystem& system) const {
  const double k = kRowErp / step_s_;
  dBodyID lever_body = bodies_[3], palm_body = bodies_[0];
  const Place lever(lever_body), palm(palm_body);
  const Vector3d arm = palm.R * pivot_, off = palm.p + arm - lever.p;
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = Vector3d::Unit(i);
    system.add_tie({lever_body, axis, Vector3d::Zero()}, {palm_body, -axis, -arm.cross(axis)},
                   k * off[i], kRowCfm);
  }
  const Vector3d tilt = lever.R.col(2).cross(palm.R.col(2));
  for (const int column : {0, 1}) {
    const Vector3d d = palm.R.col(column);
    system.add_tie({lever_body, Vector3d::Zero(), d}, {palm_body, Vector3d::Zero(), -d},
                   k * d.dot(tilt), kRowCfm);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const Place finger(bodies_[i + 1]);
    const Vector3d on_finger = finger.R * rod_on_finger_[i], on_lever = lever.R * rod_on_lever_[i];
    const Vector3d rod = finger.p + on_finger - lever.p - on_lever;
    const Vector3d d = rod.normalized();
    system.add_tie({bodies_[i + 1], d, on_finger.cross(d)}, {lever_body, -d, -on_lever.cross(d)},
                   k * (kRodLength - rod.norm()), kRowCfm);
  }
}

}  // namespace aprsim::physics
