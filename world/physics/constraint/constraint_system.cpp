#include "world/physics/constraint/constraint_system.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "world/physics/bodies/free_rotation.hpp"
#include "world/physics/constraint/joint_rows.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kCreepCorrection = 0.1;  // share that a step undoes
constexpr double kMaxOmegaGain = 5;       // [rad/s] in a step; a greater one is an impact's
constexpr double kWorkMargin = 1e-9;      // of the work of an impact, that its contacts may not do
constexpr double kDeep = 1e-4;            // [m]
constexpr double kShareResolution = 1e-10;  // of rebounds
constexpr double kConeRounding = 1e-6;      // relative distance of sliding friction from its cone
/// [rad] of a step. Bodies that turn less move as at the start of the step, to rounding.
constexpr double kLeastTurn = 1e-8;
constexpr double kFastTurn = 0.03;  // [rad] of a step

inline Vector3d tangential(const Vector3d& v, const Vector3d& n) { return v - v.dot(n) * n; }

/// A vector across `n` after a small turn about it. The error, of third order in the angle, is one
/// of the creep: nanometres.
Vector3d turned(const Vector3d& v, double angle, const Vector3d& n) {
  return (1 - 0.5 * angle * angle) * v + angle * n.cross(v);
}

/// How much farther a body's point gets in a step than its velocity at the start takes it, by the
/// step and by its lever from the centre of mass: (exp(h [omega]) - 1) / h - [omega]. A rigid
/// motion bends the path of every point; levers are those of the step's start.
Matrix3d arc_matrix(const Vector3d& omega, double step_s) {
  constexpr double kSeries = 1e-3;  // [rad^2]; below, the series hold to rounding
  const double x = omega.x(), y = omega.y(), z = omega.z();
  const double rate2 = x * x + y * y + z * z, a2 = step_s * step_s * rate2;
  // Rodrigues' formula: (sin a / a - 1) [omega] + h (1 - cos a) / a^2 [omega]^2.
  double sine = a2 * (-1.0 / 6 + a2 * (1.0 / 120 - a2 * (1.0 / 5040)));
  double cosine = 0.5 - a2 * (1.0 / 24 - a2 * (1.0 / 720 - a2 * (1.0 / 40320)));
  if (a2 > kSeries) {
    const double a = std::sqrt(a2);
    sine = std::sin(a) / a - 1;
    cosine = (1 - std::cos(a)) / a2;
  }
  const double c = step_s * cosine, xy = c * x * y, xz = c * x * z, yz = c * y * z;
  Matrix3d out;
  out << c * (x * x - rate2), xy - sine * z, xz + sine * y,  //
      xy + sine * z, c * (y * y - rate2), yz - sine * x,     //
      xz - sine * y, yz + sine * x, c * (z * z - rate2);
  return out;
}

/// The rotation that two bodies have in common: the least between theirs.
Vector3d common(const Vector3d& omega_a, const Vector3d& omega_b) {
  const Vector3d between = omega_b - omega_a;
  const double length2 = between.squaredNorm();
  if (length2 == 0) return omega_a;
  return omega_a + std::clamp(-omega_a.dot(between) / length2, 0.0, 1.0) * between;
}

/// Inertia about the centre of mass in world axes.
Matrix3d inertia_in_world(const RigidBody& body) {
  return body.R_WB() * body.inertia_B() * body.R_WB().transpose();
}

/// The angular velocity that belongs to an angular momentum.
Vector3d omega_of(const RigidBody& body, const Vector3d& momentum_W) {
  const Matrix3d& R = body.R_WB();
  return R * (body.inverse_inertia_B() * (R.transpose() * momentum_W));
}

}  // namespace

void ConstraintSystem::begin(const EngineStep& step) {
  step_s_ = step.step_s;
  gravity_W_ = step.gravity_W;
  parameters_.relaxed_tolerance_m_s = step.residual_m_s;
  forces_.clear();
  contacts_.clear();
  may_make_energy_ = false;
  last_bodies_ = {};
  last_drift_.sides = {};
  problem_.clear();
}

void ConstraintSystem::add_body(RigidBody& body) {
  // The solver works in world axes: inertia rotates with the body and is constant over the step.
  const Matrix3d inertia_W = inertia_in_world(body);
  const Twist now = {body.v_W(), body.omega_W()};
  Twist free = now;
  // Velocity V_free without constraint impulses. Bodies of a gripper are not ballistic: the arm
  // bears their weight and inertia.
  free.v += step_s_ / body.mass_kg() * body.force_W();
  if (!body.torque_W().isZero(0)) free.omega += step_s_ * (inertia_W.inverse() * body.torque_W());
  if (body.is_ballistic()) free.v += step_s_ * gravity_W_;
  body.clear_load();
  body.set_system_index(problem_.add_body(body.mass_kg(), inertia_W, body.p_W(), free, now));
  add_member(body, true);
}

/// The velocity that is expected if impulses go on as in the last step.
void ConstraintSystem::add_member(RigidBody& body, bool moves) {
  Member& member = members_.emplace_back();
  member.body = &body;
  member.moves = moves;
  member.omega_W = member.mean_omega_W = body.omega_W();
  if (!moves || !body.is_ballistic()) {
    member.turns = turns(member.omega_W);
    if (member.turns) member.arc_W = arc_matrix(member.mean_omega_W, step_s_);
    return;
  }
  const Vector3d& gain = body.omega_gain_W();
  if (gain.squaredNorm() < kMaxOmegaGain * kMaxOmegaGain) member.omega_W += gain;
  member.turns = turns(member.omega_W);
  if (!member.turns) return;
  // Second order suffices for what is only expected.
  const SolverBody& solved = problem_.at(static_cast<int>(members_.size()) - 1);
  const Vector3d torque = (solved.inertia * member.omega_W).cross(member.omega_W);
  member.mean_omega_W = member.omega_W + 0.5 * step_s_ * (solved.inverse_inertia * torque);
  member.arc_W = arc_matrix(member.mean_omega_W, step_s_);
}

bool ConstraintSystem::turns(const Sides& sides) const {
  const auto is_turning = [this](int number) {
    return number != ContactProblem::kFixed && members_[static_cast<std::size_t>(number)].turns;
  };
  return is_turning(sides.a) || is_turning(sides.b);
}

bool ConstraintSystem::turns(const Vector3d& omega_W) const {
  return step_s_ * omega_W.lpNorm<1>() > kLeastTurn;
}

/// Bodies that were not added are kinematic.
int ConstraintSystem::index_of(RigidBody* body) {
  if (body == nullptr) return ContactProblem::kFixed;
  if (body->system_index() < 0) {
    body->set_system_index(problem_.add_kinematic(body->p_W(), {body->v_W(), body->omega_W()}));
    add_member(*body, false);
  }
  return body->system_index();
}

ConstraintSystem::Sides ConstraintSystem::sides_of(RigidBody* a, RigidBody* b) {
  if (last_bodies_.a == nullptr || last_bodies_.a != a || last_bodies_.b != b) {
    const int number_a = index_of(a);
    last_bodies_ = {a, b, {number_a, index_of(b)}};
  }
  return last_bodies_.sides;
}

ContactProblem::Side ConstraintSystem::side(const RowSide& side) {
  return {index_of(side.body), side.linear, side.angular};
}

/// How much faster a side is over the step than at its start, by free rotation and by the arc of
/// the point that it holds.
double ConstraintSystem::drift_of(const RowSide& side, int number) const {
  if (number == ContactProblem::kFixed) return 0;
  const Member& member = members_[static_cast<std::size_t>(number)];
  if (!member.turns) return 0;
  return side.angular.dot(member.mean_omega_W - member.omega_W) +
         side.linear.dot(member.arc_W * side.lever_W);
}

void ConstraintSystem::add_row(const RowSide& a, const RowSide& b, double target_m_s,
                               double compliance, double lo_n, double hi_n, JointForce& force) {
  const ContactProblem::Side side_a = side(a), side_b = side(b);
  // Forces become impulses by the factor h, and ODE-style CFM [m/s per N] becomes velocity per
  // impulse.
  problem_.add_row(side_a, side_b, target_m_s - drift_of(a, side_a.body) - drift_of(b, side_b.body),
                   compliance / step_s_, lo_n * step_s_, hi_n * step_s_,
                   {force.guess_n.last * step_s_, force.guess_n.change * step_s_});
  forces_.push_back(&force);
}

void ConstraintSystem::add_joint_row(const RowSide& a, const RowSide& b, double target_m_s,
                                     double compliance, JointForce& force) {
  add_row(a, b, target_m_s, compliance, -ContactProblem::kNoBound, ContactProblem::kNoBound, force);
}

const ConstraintSystem::PairDrift& ConstraintSystem::pair_drift(const Contact& contact) {
  PairDrift& pair = last_drift_;
  if (pair.sides == contact.sides) return pair;
  pair.sides = contact.sides;
  pair.origin_W = contact.constraint->contact.p_W;
  for (Vector3d* v : {&pair.gain_W, &pair.omega_gain_W, &pair.arc_W, &pair.common_arc_W}) {
    v->setZero();
  }
  pair.arc_gradient.setZero();
  std::array<const Member*, 2> turning{};
  const auto add = [&](std::size_t side, int number, double sign) {
    if (number == ContactProblem::kFixed) return;
    const Member& member = members_[static_cast<std::size_t>(number)];
    if (!member.turns) return;
    turning[side] = &member;
    const Vector3d lever = sign * (pair.origin_W - member.body->p_W());
    const Vector3d gain = member.mean_omega_W - member.omega_W;
    pair.gain_W += gain.cross(lever);
    pair.omega_gain_W += sign * gain;
    pair.arc_W += member.arc_W * lever;
    pair.arc_gradient += sign * member.arc_W;
  };
  add(0, contact.sides.a, 1);
  add(1, contact.sides.b, -1);
  const auto [a, b] = turning;
  if (a != nullptr && b != nullptr) {
    pair.common_arc_W = arc_matrix(common(a->mean_omega_W, b->mean_omega_W), step_s_) *
                        (b->body->p_W() - a->body->p_W());
  }
  return pair;
}

const ConstraintSystem::PairVelocity& ConstraintSystem::pair_velocity(const Contact& contact) {
  PairVelocity& pair = last_velocity_;
  if (pair.sides == contact.sides) return pair;
  pair.sides = contact.sides;
  pair.origin_W = contact.constraint->contact.p_W;
  for (Vector3d* v : {&pair.v_W, &pair.omega_W, &pair.mean_omega_W}) v->setZero();
  pair.has_arcs = turns(contact.sides);
  if (pair.has_arcs) pair.arc_gradient.setZero();
  const auto add = [&](int number, double sign) {
    if (number == ContactProblem::kFixed) return;
    const Member& member = members_[static_cast<std::size_t>(number)];
    const Vector3d lever = pair.origin_W - member.body->p_W();
    Vector3d v = problem_.twist(number).v + member.mean_omega_W.cross(lever);
    if (member.turns) {
      v += member.arc_W * lever;
      pair.arc_gradient += sign * member.arc_W;
      pair.mean_omega_W += 0.5 * member.mean_omega_W;
    }
    pair.v_W += sign * v;
    pair.omega_W += sign * member.mean_omega_W;
  };
  add(contact.sides.a, 1);
  add(contact.sides.b, -1);
  return pair;
}

Vector3d ConstraintSystem::PairVelocity::at(const Vector3d& p_W) const {
  const Vector3d from = p_W - origin_W;
  const Vector3d v = v_W + omega_W.cross(from);
  return has_arcs ? v + arc_gradient * from : v;
}

/// The solver finds the velocities that the impulses leave at the start of the step. A free body's
/// angular velocity changes within it, and levers turn with the bodies, so that surfaces move apart
/// although these velocities agree.
Vector3d ConstraintSystem::drift_of(const Contact& contact) {
  if (!turns(contact.sides)) return Vector3d::Zero();
  const PairDrift& pair = pair_drift(contact);
  const Vector3d &p = contact.constraint->contact.p_W, &n = contact.constraint->contact.n_W;
  const Vector3d from = p - pair.origin_W;
  const Vector3d gain = pair.gain_W + pair.omega_gain_W.cross(from);
  const Vector3d arc = pair.arc_W + pair.arc_gradient * from;
  if (contact.constraint->contact.carried) return gain + arc;
  // Where a round surface rolls on, the point that touched leaves along the normal. Surfaces that
  // turn together do not part.
  return gain + arc - n.dot(arc - pair.common_arc_W) * n;
}

void ConstraintSystem::add_joint(const FixedJoint& joint) { add_rows(joint, *this); }
void ConstraintSystem::add_joint(const SliderJoint& joint) { add_rows(joint, *this); }
void ConstraintSystem::add_joint(const HingeJoint& joint) { add_rows(joint, *this); }
void ConstraintSystem::add_joint(const RodJoint& joint) { add_rows(joint, *this); }

void ConstraintSystem::add_contact(RigidBody* a, RigidBody* b, ContactConstraint& constraint,
                                   const ContactSetting& setting) {
  const Sides sides = sides_of(a, b);
  const ContactResponse response = contact_response(constraint, setting);
  constraint.impact_m2_s2 = response.unanswered_m2_s2;
  const Vector3d& n = constraint.contact.n_W;
  constraint.creep_W = tangential(constraint.creep_W, n);
  Contact& contact = contacts_.emplace_back();
  contact.constraint = &constraint;
  contact.sides = sides;
  contact.surface_v_W = Vector3d::Zero();
  if (constraint.belt) contact.surface_v_W = tangential(response.target_v_W, n);
  contact.compliance_m_s_ns = response.friction_compliance_m_s_n / step_s_;
  // The target makes up for the drift, and for the displacement of sticking surfaces in earlier
  // steps.
  contact.drift_v_W = drift_of(contact);
  contact.target_v_W =
      response.target_v_W - contact.drift_v_W - kCreepCorrection / step_s_ * constraint.creep_W;
  contact.rebound_m_s = response.rebound_m_s;
  // Where a body is far inside another one, corrections may contradict each other.
  const bool deep = constraint.contact.depth_m > kDeep && !setting.arm_link;
  may_make_energy_ = may_make_energy_ || response.rebound_m_s > 0 || deep;
  problem_.add_contact(
      {.a = sides.a,
       .b = sides.b,
       .p = constraint.contact.p_W,
       .n = n,
       .friction = constraint.friction,
       .spinning_m = constraint.spinning_m,
       .rolling_m = constraint.rolling_m,
       .target_v = contact.target_v_W + response.rebound_m_s * n,
       .compliance_m_s_ns = response.compliance_m_s_n / step_s_,
       .friction_compliance_m_s_ns = contact.compliance_m_s_ns,
       .impulse_ns = {step_s_ * constraint.f_guess_W.last, step_s_ * constraint.f_guess_W.change},
       .torsional_impulse_nms = {step_s_ * constraint.torque_guess_W.last,
                                 step_s_ * constraint.torque_guess_W.change}});
}

EngineOutcome ConstraintSystem::advance() {
  // Semi-implicit Euler (Stewart & Trinkle 1996): the impulses and the velocities that they leave
  // first, then the motion over the step.
  auto outcome = solve();
  take_solved_rotations();
  if (correct_targets()) {
    outcome = solve();
    take_solved_rotations();
  }
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const double force_n = problem_.row_impulse_ns(static_cast<int>(i)) / step_s_;
    forces_[i]->guess_n.record(force_n, false);
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    ContactConstraint& constraint = *contacts_[i].constraint;
    const Vector3d impulse_ns = problem_.contact_impulse_ns(static_cast<int>(i));
    update_creep(contacts_[i], impulse_ns);
    constraint.f_W = impulse_ns / step_s_;
    constraint.f_guess_W.record(constraint.f_W, outcome.warm_start_fits);
    if (constraint.has_torsion()) {
      constraint.torque_W = problem_.torsional_impulse_nms(static_cast<int>(i)) / step_s_;
      constraint.torque_guess_W.record(constraint.torque_W, outcome.warm_start_fits);
    }
    // The projection onto the cone leaves a normal part of -0 or rounding size on open contacts.
    constraint.normal_n = std::max(0.0, constraint.f_W.dot(constraint.contact.n_W));
  }
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (members_[i].moves) move(members_[i], problem_.at(static_cast<int>(i)));
    members_[i].body->set_system_index(-1);
  }
  members_.clear();
  return {.converged = outcome.converged,
          .iterations = outcome.newton_steps,
          .residual_m_s = outcome.residual_m_s};
}

void ConstraintSystem::take_solved_rotations() {
  last_drift_.sides = last_velocity_.sides = {};
  spins_ = false;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Member& member = members_[i];
    member.omega_W = member.mean_omega_W = problem_.twist(static_cast<int>(i)).omega;
    member.turns = turns(member.omega_W);
    if (!member.turns) continue;
    if (member.moves && member.body->is_ballistic()) {
      member.mean_omega_W =
          mean_free_omega(member.body->inertia_B(), member.body->q_WB(), member.omega_W, step_s_);
      member.spins = step_s_ * member.omega_W.norm() > kFastTurn;
      spins_ = spins_ || member.spins;
    }
    member.arc_W = arc_matrix(member.mean_omega_W, step_s_);
  }
}

/// Contacts of bodies that spin fast make up for the drift as it is instead of as expected: the
/// positions at the step's end then fit (SHAKE, Ryckaert et al. 1977), and tops neither nod nor
/// fall. Whether there are such contacts.
bool ConstraintSystem::correct_targets() {
  if (!spins_) return false;
  const auto spins = [this](int number) {
    return number != ContactProblem::kFixed && members_[static_cast<std::size_t>(number)].spins;
  };
  bool corrected = false;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    Contact& contact = contacts_[i];
    if (!spins(contact.sides.a) && !spins(contact.sides.b)) continue;
    corrected = true;
    const Vector3d expected_v_W = contact.drift_v_W;
    contact.drift_v_W = drift_of(contact);
    contact.target_v_W += expected_v_W - contact.drift_v_W;
  }
  for (std::size_t i = 0; corrected && i < contacts_.size(); ++i) {
    const Contact& contact = contacts_[i];
    problem_.set_target(static_cast<int>(i),
                        contact.target_v_W + contact.rebound_m_s * contact.constraint->contact.n_W);
  }
  return corrected;
}

/// Newton's law of restitution with friction may make energy (Kane 1984), and so may rebounds of
/// contacts that cannot all be reached at once. The active parts of the targets (rebounds and
/// corrections) are then reduced to where the contacts do no work.
ContactSolver::Outcome ConstraintSystem::solve() {
  auto outcome = solver_.solve(problem_, parameters_);
  if (!may_make_energy_) return outcome;
  constexpr int kMaxSearchSteps = 12;
  const auto excess = [this] {
    const Work work = contact_work();
    return work.sum_j + kWorkMargin * work.size_j;
  };
  double high = 1, high_j = excess();
  if (high_j <= 0) return outcome;
  // Regula falsi with the Illinois rule, between no active part and all of it.
  outcome = solve_with_share(0);
  double low = 0, low_j = excess(), share = 0;
  if (low_j >= 0) return outcome;
  for (int i = 0; i < kMaxSearchSteps && high - low > kShareResolution; ++i) {
    share = std::clamp((low * high_j - high * low_j) / (high_j - low_j), low, high);
    outcome = solve_with_share(share);
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
  if (share == low) return outcome;
  outcome = solve_with_share(low);
  // Solutions need not be unique: from another start there may be another one.
  return excess() <= 0 ? outcome : solve_with_share(0);
}

ContactSolver::Outcome ConstraintSystem::solve_with_share(double share) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& contact = contacts_[i];
    const Vector3d& n = contact.constraint->contact.n_W;
    // Contacts with this target can do no work on the bodies.
    const Vector3d passive_v_W = contact.surface_v_W + std::min(0.0, contact.target_v_W.dot(n)) * n;
    const Vector3d active_v_W = contact.target_v_W + contact.rebound_m_s * n - passive_v_W;
    problem_.set_target(static_cast<int>(i), passive_v_W + share * active_v_W);
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
void ConstraintSystem::update_creep(const Contact& contact, const Vector3d& impulse_ns) {
  ContactConstraint& constraint = *contact.constraint;
  const Vector3d &p = constraint.contact.p_W, &n = constraint.contact.n_W;
  const double normal_ns = impulse_ns.dot(n);
  // The creep of open contacts is not kept.
  if (normal_ns <= 0) return;
  const Vector3d friction_ns = impulse_ns - normal_ns * n;
  const double most_ns = (1 - kConeRounding) * constraint.friction * normal_ns;
  const PairVelocity& pair = pair_velocity(contact);
  if (friction_ns.squaredNorm() >= most_ns * most_ns) {
    // A sliding contact is stretched as far as its friction stretches it.
    constraint.creep_W = -step_s_ / kCreepCorrection * contact.compliance_m_s_ns * friction_ns;
  } else {
    constraint.creep_W += step_s_ * tangential(pair.at(p) - contact.surface_v_W, n);
  }
  // It turns with the surfaces.
  if (!pair.has_arcs) return;
  constraint.creep_W = turned(constraint.creep_W, step_s_ * pair.mean_omega_W.dot(n), n);
}

/// The pose from the mean velocities over the step, then the velocities at its end. The angular one
/// follows from the momentum, which free rotation keeps exactly.
void ConstraintSystem::move(const Member& member, const SolverBody& solved) const {
  const Vector3d& v_W = solved.twist.v;
  RigidBody& body = *member.body;
  const bool changes = member.turns && body.is_ballistic();
  const Vector3d gain_W = member.omega_W - body.omega_W();
  const Vector3d momentum_W = solved.inertia * member.omega_W + body.momentum_residue_W();
  body.set_position(body.p_W() + step_s_ * v_W);
  body.set_orientation(rotation_by(step_s_ * member.mean_omega_W) * body.q_WB());
  const Vector3d omega_W = changes ? omega_of(body, momentum_W) : member.omega_W;
  body.set_velocity(v_W, omega_W);
  // The rounding error of omega is kept, so that nothing adds up over many steps.
  if (changes) body.set_momentum_residue(momentum_W - inertia_in_world(body) * omega_W);
  if (body.is_ballistic()) body.set_omega_gain(gain_W);
}

}  // namespace aprsim::physics
