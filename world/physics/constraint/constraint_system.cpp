#include "world/physics/constraint/constraint_system.hpp"

#include <algorithm>
#include <cmath>

#include "world/physics/bodies/free_rotation.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kCreepCorrection = 0.1;  // share that a step undoes
constexpr double kWorkMargin = 1e-9;      // of the work of an impact, that its contacts may not do
constexpr double kShareResolution = 1e-10;  // of rebounds
constexpr double kConeRounding = 1e-6;      // relative distance of sliding friction from its cone

Vector3d tangential(const Vector3d& v, const Vector3d& n) { return v - v.dot(n) * n; }

/// How much farther a body's point at `lever` from its centre of mass gets in a step than its
/// velocity at the start takes it, by the step: (exp(h [omega]) - 1) r / h - omega x r. A rigid
/// motion bends the path of every point; levers are those of the step's start.
Vector3d arc_velocity(const Vector3d& omega, const Vector3d& lever, double step_s) {
  const double angle = step_s * omega.norm();
  // Rodrigues' formula; its factors as series, which hold to rounding below 0.1 rad.
  const double a2 = angle * angle;
  const double sine =
      angle < 0.1 ? -a2 / 6 * (1 - a2 / 20 * (1 - a2 / 42)) : std::sin(angle) / angle - 1;
  const double cosine = angle < 0.1 ? 0.5 * (1 - a2 / 12 * (1 - a2 / 30 * (1 - a2 / 56)))
                                    : (1 - std::cos(angle)) / a2;
  const Vector3d across = omega.cross(lever);
  return sine * across + step_s * cosine * omega.cross(across);
}

/// Inertia about the centre of mass in world axes.
Matrix3d inertia_in_world(const RigidBody& body) {
  return body.R_WB() * body.inertia_B() * body.R_WB().transpose();
}

}  // namespace

void ConstraintSystem::begin(double step_s, const Eigen::Vector3d& gravity_W, double residual_m_s) {
  step_s_ = step_s;
  gravity_W_ = gravity_W;
  parameters_.relaxed_tolerance_m_s = residual_m_s;
  moves_.clear();
  momentum_W_.clear();
  forces_.clear();
  contacts_.clear();
  rebounds_ = false;
  problem_.clear();
}

void ConstraintSystem::add_body(RigidBody& body) {
  // The solver works in world axes: inertia rotates with the body and is constant over the step.
  const Matrix3d inertia_W = inertia_in_world(body);
  const Twist now = {body.v_W(), body.omega_W()};
  Twist free = now;
  // Velocity V_free at the end of the step without constraint impulses. Bodies of a gripper are not
  // ballistic: the arm bears their weight and inertia.
  if (body.is_ballistic()) {
    free.omega = mean_free_omega(body.inertia_B(), body.q_WB(), now.omega, step_s_);
  }
  // The solver finds the mean angular velocity over the step. The momentum of a free rotation is
  // the start's, not that of the mean velocity at the attitude of the start.
  momentum_W_.emplace_back(inertia_W * (now.omega - free.omega));
  free.v += step_s_ / body.mass_kg() * body.force_W();
  if (!body.torque_W().isZero(0)) free.omega += step_s_ * (inertia_W.inverse() * body.torque_W());
  if (body.is_ballistic()) free.v += step_s_ * gravity_W_;
  body.clear_load();
  body.set_system_index(problem_.add_body(body.mass_kg(), inertia_W, body.p_W(), free, now));
  members_.push_back(&body);
  moves_.push_back(1);
}

/// Bodies that were not added are kinematic.
int ConstraintSystem::index_of(RigidBody* body) {
  if (body == nullptr) return ContactProblem::kFixed;
  if (body->system_index() < 0) {
    body->set_system_index(problem_.add_kinematic(body->p_W(), {body->v_W(), body->omega_W()}));
    members_.push_back(body);
    momentum_W_.emplace_back(Vector3d::Zero());
    moves_.push_back(0);
  }
  return body->system_index();
}

ContactProblem::Side ConstraintSystem::side(const RowSide& side) {
  return {index_of(side.body), side.linear, side.angular};
}

void ConstraintSystem::add_row(const RowSide& a, const RowSide& b, double target_m_s,
                               double compliance, double lo_n, double hi_n, RowForce& force) {
  // Forces become impulses by the factor h, and ODE-style CFM [m/s per N] becomes velocity per
  // impulse.
  problem_.add_row(side(a), side(b), target_m_s, compliance / step_s_, lo_n * step_s_,
                   hi_n * step_s_, {force.guess_n.last * step_s_, force.guess_n.change * step_s_});
  forces_.push_back(&force);
}

void ConstraintSystem::add_joint_row(const RowSide& a, const RowSide& b, double target_m_s,
                                     double compliance, RowForce& force) {
  add_row(a, b, target_m_s, compliance, -ContactProblem::kNoBound, ContactProblem::kNoBound, force);
}

ConstraintSystem::Sides ConstraintSystem::sides(RigidBody* a, RigidBody* b) {
  return {index_of(a), index_of(b)};
}

void ConstraintSystem::add_contact(ContactConstraint& constraint, const Sides& sides,
                                   const ContactResponse& response) {
  const Eigen::Vector3d &p = constraint.contact.p_W, &n = constraint.contact.n_W;
  // Levers turn with the bodies, so that the surfaces move apart although their velocities at the
  // start agree. The target makes up for that, and for what has come of it in earlier steps.
  const auto arc = [&](int member) -> Vector3d {
    if (member == ContactProblem::kFixed) return Vector3d::Zero();
    const RigidBody& body = *members_[static_cast<std::size_t>(member)];
    return arc_velocity(body.omega_W(), p - body.p_W(), step_s_);
  };
  constraint.creep_W = tangential(constraint.creep_W, n);
  const Vector3d bias =
      -tangential(arc(sides.a) - arc(sides.b), n) - kCreepCorrection / step_s_ * constraint.creep_W;
  const Vector3d target_v_W = response.target_v_W + bias;
  problem_.add_contact(
      {.a = sides.a,
       .b = sides.b,
       .p = constraint.contact.p_W,
       .n = constraint.contact.n_W,
       .friction = constraint.friction,
       .spinning_m = constraint.spinning_m,
       .rolling_m = constraint.rolling_m,
       .target_v = target_v_W + response.rebound_m_s * n,
       .compliance_m_s_ns = response.compliance_m_s_n / step_s_,
       .friction_compliance_m_s_ns = response.friction_compliance_m_s_n / step_s_,
       .impulse_ns = {step_s_ * constraint.f_guess_W.last, step_s_ * constraint.f_guess_W.change},
       .torsional_impulse_nms = {step_s_ * constraint.torque_guess_W.last,
                                 step_s_ * constraint.torque_guess_W.change}});
  contacts_.push_back({.constraint = &constraint,
                       .sides = sides,
                       .target_v_W = target_v_W,
                       .surface_v_W = tangential(response.target_v_W, n),
                       .compliance_m_s_ns = response.friction_compliance_m_s_n / step_s_,
                       .rebound_m_s = response.rebound_m_s});
  rebounds_ = rebounds_ || response.rebound_m_s > 0;
}

ContactSolver::Outcome ConstraintSystem::advance() {
  // Semi-implicit Euler (Stewart & Trinkle 1996): impulses and velocities at the end of the step
  // first, then the poses follow from these velocities.
  const auto outcome = solve();
  for (std::size_t i = 0; i < contacts_.size(); ++i) update_creep(static_cast<int>(i));
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (moves_[i] != 0) move(*members_[i], problem_.twist(static_cast<int>(i)), momentum_W_[i]);
    members_[i]->set_system_index(-1);
  }
  members_.clear();
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const double force_n = problem_.row_impulse_ns(static_cast<int>(i)) / step_s_;
    forces_[i]->guess_n.record(force_n, false);
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    ContactConstraint& constraint = *contacts_[i].constraint;
    constraint.f_W = problem_.contact_impulse_ns(static_cast<int>(i)) / step_s_;
    constraint.torque_W = problem_.torsional_impulse_nms(static_cast<int>(i)) / step_s_;
    constraint.f_guess_W.record(constraint.f_W, outcome.warm_start_fits);
    constraint.torque_guess_W.record(constraint.torque_W, outcome.warm_start_fits);
    // The projection onto the cone leaves a normal part of -0 or rounding size on open contacts.
    constraint.normal_n = std::max(0.0, constraint.f_W.dot(constraint.contact.n_W));
  }
  return outcome;
}

/// Newton's law of restitution with friction may make energy (Kane 1984), and so may rebounds of
/// contacts that cannot all be reached at once. The rebounds are then reduced to where the contacts
/// do no work.
ContactSolver::Outcome ConstraintSystem::solve() {
  auto outcome = solver_.solve(problem_, parameters_);
  if (!rebounds_) return outcome;
  constexpr int kMaxSearchSteps = 12;
  const auto excess = [this] {
    const Work work = contact_work();
    return work.sum_j + kWorkMargin * work.size_j;
  };
  double high = 1, high_j = excess();
  if (high_j <= 0) return outcome;
  // Regula falsi with the Illinois rule, between no rebound and all of it.
  outcome = solve_with_rebounds(0);
  double low = 0, low_j = excess(), share = 0;
  if (low_j >= 0) return outcome;
  for (int i = 0; i < kMaxSearchSteps && high - low > kShareResolution; ++i) {
    share = std::clamp((low * high_j - high * low_j) / (high_j - low_j), low, high);
    outcome = solve_with_rebounds(share);
    const double now_j = excess();
    if (now_j <= 0) {
      if (now_j >= -kWorkMargin * contact_work().size_j) return outcome;
      low = share;
      low_j = now_j;
      high_j *= 0.5;
    } else {
      high = share;
      high_j = now_j;
      low_j *= 0.5;
    }
  }
  return share == low ? outcome : solve_with_rebounds(low);
}

ContactSolver::Outcome ConstraintSystem::solve_with_rebounds(double share) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& contact = contacts_[i];
    const double rebound_m_s = share * contact.rebound_m_s;
    problem_.set_target(static_cast<int>(i),
                        contact.target_v_W + rebound_m_s * contact.constraint->contact.n_W);
  }
  return solver_.solve(problem_, parameters_);
}

/// Impulses times the mean of the relative velocities without and with them: the change of the
/// kinetic energy, less what moving surfaces do.
ConstraintSystem::Work ConstraintSystem::contact_work() const {
  Work work;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& contact = contacts_[i];
    const int index = static_cast<int>(i);
    const Vector3d impulse_ns = problem_.contact_impulse_ns(index);
    if (impulse_ns.isZero(0)) continue;
    Vector3d before = -contact.surface_v_W, after = before, turn = Vector3d::Zero();
    const auto add = [&](int member, double sign) {
      if (member == ContactProblem::kFixed) return;
      const SolverBody& body = problem_.at(member);
      const Vector3d lever = contact.constraint->contact.p_W - body.com;
      before += sign * (body.free_twist.v + body.free_twist.omega.cross(lever));
      after += sign * (body.twist.v + body.twist.omega.cross(lever));
      turn += sign * (body.free_twist.omega + body.twist.omega);
    };
    add(contact.sides.a, 1);
    add(contact.sides.b, -1);
    const double linear_j = 0.5 * impulse_ns.dot(before + after);
    const double angular_j = 0.5 * problem_.torsional_impulse_nms(index).dot(turn);
    work.sum_j += linear_j + angular_j;
    work.size_j += 0.5 * impulse_ns.norm() * (before.norm() + after.norm());
  }
  return work;
}

/// Where the surfaces stick, adds the displacement along them in this step. The bodies have not
/// moved yet.
void ConstraintSystem::update_creep(int index) const {
  const Contact& contact = contacts_[static_cast<std::size_t>(index)];
  ContactConstraint& constraint = *contact.constraint;
  const Eigen::Vector3d &p = constraint.contact.p_W, &n = constraint.contact.n_W;
  Vector3d velocity = Vector3d::Zero(), arc = Vector3d::Zero();
  const auto add = [&](int member, double sign) {
    if (member == ContactProblem::kFixed) return;
    const Twist& twist = problem_.twist(member);
    const Vector3d lever = p - members_[static_cast<std::size_t>(member)]->p_W();
    velocity += sign * (twist.v + twist.omega.cross(lever));
    arc += sign * arc_velocity(twist.omega, lever, step_s_);
  };
  add(contact.sides.a, 1);
  add(contact.sides.b, -1);
  const Vector3d& impulse_ns = problem_.contact_impulse_ns(index);
  const double normal_ns = impulse_ns.dot(n);
  const bool slides = normal_ns > 0 && tangential(impulse_ns, n).norm() >=
                                           (1 - kConeRounding) * constraint.friction * normal_ns;
  const Vector3d slip = tangential(velocity, n) - contact.surface_v_W;
  // A sliding contact is stretched as far as its friction stretches it.
  constraint.creep_W = slides
                           ? Vector3d(-step_s_ / kCreepCorrection * contact.compliance_m_s_ns *
                                      tangential(impulse_ns, n))
                           : Vector3d(constraint.creep_W + step_s_ * (slip + tangential(arc, n)));
}

/// The pose from the mean velocities over the step, then the velocities at its end. The angular one
/// follows from the momentum, which free rotation keeps exactly.
void ConstraintSystem::move(RigidBody& body, const Twist& twist, const Vector3d& momentum_W) const {
  const Vector3d end_momentum_W = inertia_in_world(body) * twist.omega + momentum_W;
  body.set_position(body.p_W() + step_s_ * twist.v);
  // Rotation by the exponential map of omega over the step.
  const double half = 0.5 * step_s_, angle = half * twist.omega.norm();
  const double sinc = angle < 1e-4 ? 1 - angle * angle / 6 : std::sin(angle) / angle;
  const Vector3d turn = half * sinc * twist.omega;
  body.set_orientation(Eigen::Quaterniond(std::cos(angle), turn.x(), turn.y(), turn.z()) *
                       body.q_WB());
  body.set_velocity(twist.v, body.is_ballistic()
                                 ? Vector3d(inertia_in_world(body).inverse() * end_momentum_W)
                                 : twist.omega);
}

}  // namespace aprsim::physics
