#include "world/physics/constraint/contact_problem.hpp"

#include <Eigen/LU>

#include "world/base/simd/vector_clones.hpp"

namespace aprsim::physics {

// ---- the problem

void ContactProblem::clear() {
  bodies_.clear();
  moving_.clear();
  rows_.clear();
  pack_count_ = 0;
  locations_.clear();
  complete_ = at_rest_ = false;
}

int ContactProblem::add_body(double mass_kg, const Matrix3& inertia, const Vector3& com,
                             const Twist& free, const Twist& now) {
  SolverBody body;
  body.kg = mass_kg;
  body.inverse_kg = 1 / mass_kg;
  body.inertia = inertia;
  body.inverse_inertia = inertia.inverse();
  body.com = com;
  body.free_twist = free;
  body.twist = now;
  body.unknown = static_cast<int>(moving_.size());
  moving_.push_back(static_cast<int>(bodies_.size()));
  bodies_.push_back(body);
  return static_cast<int>(bodies_.size()) - 1;
}

int ContactProblem::add_kinematic(const Vector3& com, const Twist& twist) {
  SolverBody body;
  body.com = com;
  body.free_twist = body.twist = twist;
  bodies_.push_back(body);
  return static_cast<int>(bodies_.size()) - 1;
}

int ContactProblem::add_row(const Side& a, const Side& b, double target, double compliance,
                            double lower_ns, double upper_ns,
                            const ImpulseGuess<double>& guess_ns) {
  SolverRow row;
  row.a = a;
  row.b = b;
  row.target = target;
  row.compliance = compliance;
  row.is_angular = a.linear.isZero(0) && b.linear.isZero(0);
  row.lower = lower_ns;
  row.upper = upper_ns;
  // A warm start outside of its set would not be a feasible proximal point.
  row.gamma = std::clamp(guess_ns.last + guess_ns.change, lower_ns, upper_ns);
  row.last_gamma = std::clamp(guess_ns.last, lower_ns, upper_ns);
  for (const Side* side : {&row.a, &row.b}) {
    if (side->body == kFixed) continue;
    const SolverBody& body = at(side->body);
    // W_i = sum over the sides of J_i M^-1 J_i'. It scales residual and proximal term, so that both
    // are independent of mass.
    row.delassus += body.inverse_kg * side->linear.squaredNorm() +
                    side->angular.dot(body.inverse_inertia * side->angular);
  }
  rows_.push_back(row);
  return static_cast<int>(rows_.size()) - 1;
}

void ContactProblem::set_target(int contact, const Vector3& target_v) {
  const auto& [pack, lane] = locations_[index(contact)];
  packs_[index(pack)].set_target(lane, target_v);
}

void ContactProblem::complete(const ContactSolverParameters& parameters) {
  if (complete_) return;
  complete_contacts(parameters);
  mark_actuated();
  at_rest_ = are_slow(parameters);
  complete_ = true;
}

APRSIM_VECTOR_CLONES void ContactProblem::complete_contacts(
    const ContactSolverParameters& parameters) {
  for (ContactPack& pack : packs()) pack.complete(find(pack.a), find(pack.b), parameters);
}

/// Contacts of actuated bodies keep the strict tolerance: their residual would become creep of a
/// held part.
void ContactProblem::mark_actuated() {
  for (const SolverRow& row : rows_) {
    for (const Side* side : {&row.a, &row.b}) {
      if (side->body != kFixed) at(side->body).actuated = true;
    }
  }
  const auto is_actuated = [this](int body) { return body != kFixed && at(body).actuated; };
  for (ContactPack& pack : packs()) pack.actuated = is_actuated(pack.a) || is_actuated(pack.b);
}

bool ContactProblem::are_slow(const ContactSolverParameters& parameters) const {
  // The test uses the velocities before the step. At rest, residuals of either sign add up over
  // thousands of steps, so that a stricter tolerance pays.
  return rows_.empty() && std::ranges::all_of(moving_, [&](int body) {
           const Twist& twist = at(body).twist;
           return std::max(twist.v.norm(), parameters.angular_lever_m * twist.omega.norm()) <
                  parameters.rest_speed_m_s;
         });
}

// ---- a part of another problem

int ContactProblem::add_copy(const SolverBody& body) {
  const int number = body_count();
  bodies_.push_back(body);
  if (body.moves()) {
    bodies_.back().unknown = static_cast<int>(moving_.size());
    moving_.push_back(number);
  }
  return number;
}

void ContactProblem::add_copy(const SolverRow& row, int a, int b) {
  rows_.push_back(row);
  rows_.back().a.body = a;
  rows_.back().b.body = b;
}

void ContactProblem::add_copy(const ContactPack& pack, int a, int b) {
  ContactPack& own = add_pack();
  own = pack;
  own.a = a;
  own.b = b;
}

void ContactProblem::complete_part() {
  for (const SolverRow& row : rows_) {
    apply_impulse(row.a.body, -row.gamma * row.a.linear, -row.gamma * row.a.angular);
    apply_impulse(row.b.body, -row.gamma * row.b.linear, -row.gamma * row.b.angular);
  }
  for (const ContactPack& pack : packs()) {
    const ContactPack::BodyImpulses impulses = pack.body_impulses();
    apply_impulse(pack, {-1 * impulses.on_a, -1 * impulses.against_b});
  }
  for (const int i : moving_) at(i).free_twist = at(i).twist;
  complete_ = true;
}

// ---- the solution

ContactProblem::Vector3 ContactProblem::contact_impulse_ns(int contact) const {
  const auto& [pack, lane] = locations_[index(contact)];
  return packs_[index(pack)].impulse_W(lane);
}

ContactProblem::Vector3 ContactProblem::torsional_impulse_nms(int contact) const {
  const auto& [pack, lane] = locations_[index(contact)];
  return packs_[index(pack)].torsion_W(lane);
}

// ---- impulses and velocities

APRSIM_VECTOR_CLONES void ContactProblem::set_last_impulses() {
  for (SolverRow& row : rows_) row.gamma = row.last_gamma;
  for (ContactPack& pack : packs()) pack.set_last_impulse();
}

APRSIM_VECTOR_CLONES void ContactProblem::velocities_from_impulses() {
  // V = V_free + M^-1 J' gamma. The velocities are rebuilt from the impulses, not accumulated, so
  // that rounding of many Newton steps cannot drift.
  for (const int i : moving_) {
    SolverBody& body = at(i);
    body.twist = body.free_twist;
  }
  for (const SolverRow& row : rows_) {
    if (row.gamma == 0) continue;
    apply_impulse(row.a.body, row.gamma * row.a.linear, row.gamma * row.a.angular);
    apply_impulse(row.b.body, row.gamma * row.b.linear, row.gamma * row.b.angular);
  }
  // Impulses of a pair are summed first: both bodies then get the same sum, so that large ones
  // which balance each other leave the momentum as it is, to rounding of their sum.
  for (std::size_t first = 0; first < packs().size();) {
    const std::span<ContactPack> pair = packs_of_pair(first);
    first += pair.size();
    if (pair.size() == 1) {
      if (!pair[0].is_idle()) apply_impulse(pair[0], pair[0].body_impulses());
      continue;
    }
    ContactPack::BodyImpulses sum{Vector6::zero(), Vector6::zero()};
    for (const ContactPack& pack : pair) {
      if (!pack.is_idle()) sum += pack.body_impulses();
    }
    apply_impulse(pair[0], sum);
  }
}

inline double ContactProblem::velocity_of(const Side& side) const {
  if (side.body == kFixed) return 0;
  const Twist& twist = at(side.body).twist;
  return side.linear.dot(twist.v) + side.angular.dot(twist.omega);
}

APRSIM_VECTOR_CLONES void ContactProblem::evaluate_constraint_velocities() {
  for (SolverRow& row : rows_) row.v_c = velocity_of(row.a) + velocity_of(row.b) - row.target;
  for (ContactPack& pack : packs()) pack.evaluate_velocities(find(pack.a), find(pack.b));
}

APRSIM_VECTOR_CLONES ContactResidual
ContactProblem::residual(const ContactSolverParameters& parameters) {
  // The stopping test uses the velocities that the impulses cause. Newton's own velocities fulfil
  // momentum balance only within its tolerance, and may look converged where they are not.
  for (const int i : moving_) at(i).newton_twist = at(i).twist;
  update_velocities();
  ContactResidual out;
  for (const SolverRow& row : rows_) {
    out.actuated_m_s = std::max(out.actuated_m_s, row.residual(parameters.angular_lever_m));
  }
  for (const ContactPack& pack : packs()) {
    double& of = pack.actuated ? out.actuated_m_s : out.relaxed_m_s;
    of = std::max(of, pack.residual(parameters));
  }
  return out;
}

void ContactProblem::return_to_newton_velocities() {
  for (const int i : moving_) at(i).twist = at(i).newton_twist;
  evaluate_constraint_velocities();
}

// ---- the proximal point

APRSIM_VECTOR_CLONES void ContactProblem::set_proximal_weight(
    double weight, const ContactSolverParameters& parameters) {
  for (SolverRow& row : rows_) row.set_proximal_weight(weight);
  for (ContactPack& pack : packs()) pack.set_proximal_weight(weight, parameters);
}

APRSIM_VECTOR_CLONES void ContactProblem::update_proximal_point() {
  // Rockafellar 1976: the present impulses become the centre of the next proximal term.
  for (SolverRow& row : rows_) row.proximal_gamma = row.gamma;
  for (ContactPack& pack : packs()) pack.update_proximal_point();
  update_de_saxce_correction();
}

void ContactProblem::return_to_proximal_point() {
  // A rejected outer iteration must leave no trace, so the velocities are rebuilt as well.
  for (SolverRow& row : rows_) row.gamma = row.proximal_gamma;
  for (ContactPack& pack : packs()) pack.return_to_proximal_point();
  update_velocities();
}

APRSIM_VECTOR_CLONES void ContactProblem::update_de_saxce_correction() {
  for (ContactPack& pack : packs()) pack.update_de_saxce_correction();
}

}  // namespace aprsim::physics
