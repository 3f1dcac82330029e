#include "world/physics/constraint/constraint_system.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace aprsim::physics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Change of angular velocity of a free body in a step: one Newton iteration of the implicit Euler
/// step of I omega' + omega x I omega = 0, as in Catto, "Numerical Methods" (GDC 2015).
Vector3d gyroscopic(const Matrix3d& inertia_W, const Vector3d& omega, double step_s) {
  const Vector3d momentum = inertia_W * omega;
  const auto cross = [](const Vector3d& v) {
    Matrix3d m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
  };
  const Matrix3d slope = inertia_W + step_s * (cross(omega) * inertia_W - cross(momentum));
  return -step_s * (slope.inverse() * omega.cross(momentum));
}

// A body's number in the system, kept with the body itself; 0 = none.
void set_number(dBodyID body, int number) {
  dBodySetData(body, reinterpret_cast<void*>(static_cast<std::intptr_t>(number + 1)));
}
int get_number(dBodyID body) {
  return static_cast<int>(reinterpret_cast<std::intptr_t>(dBodyGetData(body))) - 1;
}

}  // namespace

void ConstraintSystem::begin(double step_s, double residual_m_s) {
  step_s_ = step_s;
  parameters_.relaxed_tolerance_m_s = residual_m_s;
  for (dBodyID body : known_) set_number(body, -1);
  known_.clear();
  moves_.clear();
  forces_.clear();
  contacts_.clear();
  problem_.clear();
}

void ConstraintSystem::add_body(dBodyID ode) {
  dMass mass;
  dBodyGetMass(ode, &mass);
  const Matrix3d R = ode::matrix(dBodyGetRotation(ode));
  const Matrix3d inertia_W = R * ode::matrix(mass.I) * R.transpose();
  const Twist now = {ode::vector(dBodyGetLinearVel(ode)), ode::vector(dBodyGetAngularVel(ode))};
  Twist free = now;
  if (dBodyGetGyroscopicMode(ode) != 0) free.omega += gyroscopic(inertia_W, free.omega, step_s_);
  free.v += step_s_ / mass.mass * ode::vector(dBodyGetForce(ode));
  const Vector3d torque_W = ode::vector(dBodyGetTorque(ode));
  if (!torque_W.isZero(0)) free.omega += step_s_ * (inertia_W.inverse() * torque_W);
  if (dBodyGetGravityMode(ode) != 0) {
    dVector3 gravity;
    dWorldGetGravity(dBodyGetWorld(ode), gravity);
    free.v += step_s_ * ode::vector(gravity);
  }
  dBodySetForce(ode, 0, 0, 0);
  dBodySetTorque(ode, 0, 0, 0);
  set_number(
      ode, problem_.add_body(mass.mass, inertia_W, ode::vector(dBodyGetPosition(ode)), free, now));
  known_.push_back(ode);
  moves_.push_back(1);
}

/// Bodies that were not added move as they do.
int ConstraintSystem::number_of(dBodyID body) {
  if (body == nullptr) return ContactProblem::kFixed;
  const int known = get_number(body);
  if (known >= 0) return known;
  const int number = problem_.add_kinematic(
      ode::vector(dBodyGetPosition(body)),
      {ode::vector(dBodyGetLinearVel(body)), ode::vector(dBodyGetAngularVel(body))});
  set_number(body, number);
  known_.push_back(body);
  moves_.push_back(0);
  return number;
}

ContactProblem::Side ConstraintSystem::side(const RowSide& side) {
  return {number_of(side.body), side.linear, side.angular};
}

void ConstraintSystem::add_row(const RowSide& a, const RowSide& b, double target_m_s,
                               double compliance, double lo_n, double hi_n, RowForce& force) {
  problem_.add_row(side(a), side(b), target_m_s, compliance / step_s_, lo_n * step_s_,
                   hi_n * step_s_, {force.guess_n.last * step_s_, force.guess_n.change * step_s_});
  forces_.push_back(&force);
}

void ConstraintSystem::add_joint_row(const RowSide& a, const RowSide& b, double target_m_s,
                                     double compliance, RowForce& force) {
  add_row(a, b, target_m_s, compliance, -ContactProblem::kNoBound, ContactProblem::kNoBound, force);
}

ConstraintSystem::Sides ConstraintSystem::sides(dBodyID a, dBodyID b) {
  return {number_of(a), number_of(b)};
}

void ConstraintSystem::add_contact(ContactConstraint& constraint, const Sides& sides,
                                   const ContactResponse& response) {
  problem_.add_contact(
      {.a = sides.a,
       .b = sides.b,
       .p = constraint.contact.p_W,
       .n = constraint.contact.n_W,
       .friction = constraint.friction,
       .spinning_m = constraint.spinning_m,
       .rolling_m = constraint.rolling_m,
       .target_v = response.target_v_W,
       .compliance_m_s_ns = response.compliance_m_s_n / step_s_,
       .impulse_ns = {step_s_ * constraint.f_guess_W.last, step_s_ * constraint.f_guess_W.change},
       .torsional_impulse_nms = {step_s_ * constraint.torque_guess_W.last,
                                 step_s_ * constraint.torque_guess_W.change}});
  contacts_.push_back(&constraint);
}

ContactSolver::Outcome ConstraintSystem::advance() {
  const auto outcome = solver_.solve(problem_, parameters_);
  for (std::size_t i = 0; i < known_.size(); ++i) {
    if (moves_[i] != 0) move(known_[i], problem_.twist(static_cast<int>(i)));
  }
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const double force_n = problem_.row_impulse_ns(static_cast<int>(i)) / step_s_;
    forces_[i]->guess_n.note(force_n, false);
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    ContactConstraint& constraint = *contacts_[i];
    constraint.f_W = problem_.contact_impulse_ns(static_cast<int>(i)) / step_s_;
    constraint.torque_W = problem_.torsional_impulse_nms(static_cast<int>(i)) / step_s_;
    constraint.f_guess_W.note(constraint.f_W, outcome.warm_start_fits);
    constraint.torque_guess_W.note(constraint.torque_W, outcome.warm_start_fits);
    constraint.normal_n = std::max(0.0, constraint.f_W.dot(constraint.contact.n_W));
  }
  return outcome;
}

/// Positions from the new velocities.
void ConstraintSystem::move(dBodyID ode, const Twist& twist) const {
  const Vector3d p = ode::vector(dBodyGetPosition(ode)) + step_s_ * twist.v;
  // Rotation by the exponential map of omega over the step.
  const dReal* q = dBodyGetQuaternion(ode);
  const double half = 0.5 * step_s_, angle = half * twist.omega.norm();
  const double sinc = angle < 1e-4 ? 1 - angle * angle / 6 : std::sin(angle) / angle;
  const Vector3d turn = half * sinc * twist.omega;
  const Eigen::Quaterniond turned =
      Eigen::Quaterniond(std::cos(angle), turn.x(), turn.y(), turn.z()) *
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  const dQuaternion next = {turned.w(), turned.x(), turned.y(), turned.z()};
  ode::set_velocity(ode, twist.v, twist.omega);
  ode::set_position(ode, p);
  dBodySetQuaternion(ode, next);
}

}  // namespace aprsim::physics
