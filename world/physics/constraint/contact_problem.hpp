#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "world/physics/constraint/contact_description.hpp"
#include "world/physics/constraint/contact_pack.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/solver_body.hpp"
#include "world/physics/constraint/solver_row.hpp"

namespace aprsim::physics {

/// Distance of the impulses from the solution: the natural map of the complementarity, in units of
/// velocity.
struct ContactResidual {
  double actuated_m_s = 0;  ///< of rows, and of contacts of bodies that rows act on
  double relaxed_m_s = 0;   ///< of all other contacts
  [[nodiscard]] double max_m_s() const { return std::max(actuated_m_s, relaxed_m_s); }
};

/// One step of rigid bodies with joints, drives and contacts: find impulses gamma with
///
///     M (V - V_free) = J' gamma,   v_c = J V - target,
///     -(v_c + compliance gamma + De Saxce correction) in the normal cone of gamma's set,
///
/// where contact impulses lie in Coulomb's circular cones, torques within limits, and rows within
/// bounds. It holds the bodies, rows and contacts with the current iterate, which ContactSolver
/// brings to the solution. SI, world axes. No call allocates after warm-up.
class ContactProblem {
 public:
  using Vector3 = Eigen::Vector3d;
  using Matrix3 = Eigen::Matrix3d;
  using Side = SolverRow::Side;
  static constexpr double kNoBound = std::numeric_limits<double>::infinity();
  static constexpr int kFixed = -1;  ///< number of a body that is fixed to the world

  // ---- the problem

  void clear();
  /// A body that impulses move. `free` is its part of V_free, the velocity at the end of the step
  /// without impulses; `now` is the present velocity. Returns its number.
  int add_body(double mass_kg, const Matrix3& inertia, const Vector3& com, const Twist& free,
               const Twist& now);
  /// A body with a prescribed velocity. Rows and contacts take it as any other.
  int add_kinematic(const Vector3& com, const Twist& twist);
  /// A row whose impulse stays within bounds: sum of both sides' velocities = target - compliance
  /// times impulse, where no bound is reached. Returns its number.
  int add_row(const Side& a, const Side& b, double target, double compliance, double lower_ns,
              double upper_ns, const ImpulseGuess<double>& guess_ns = {0, 0});
  /// Contacts of the same two bodies are added one after the other. Returns its number.
  int add_contact(const ContactDescription& contact);

  // ---- a part of another problem, in place of the additions above

  /// A body with its present velocity; kinematic if it is that. Returns its number.
  int add_copy(const SolverBody& body);
  /// A row or contacts with their present impulses, between bodies of this problem.
  void add_copy(const SolverRow& row, int a, int b);
  void add_copy(const ContactPack& pack, int a, int b);
  /// After the last copy. V_free becomes the velocity without the copied impulses, so that all
  /// constraints that were not copied keep theirs.
  void complete_part();

  // ---- the solution

  [[nodiscard]] int body_count() const { return static_cast<int>(bodies_.size()); }
  [[nodiscard]] const Twist& twist(int body) const { return at(body).twist; }
  [[nodiscard]] double row_impulse_ns(int row) const { return rows_[index(row)].gamma; }
  /// On body a.
  [[nodiscard]] Vector3 contact_impulse_ns(int contact) const;
  [[nodiscard]] Vector3 torsional_impulse_nms(int contact) const;

  // ---- the iterate, for the parts of ContactSolver

  /// After the last addition: derives what the iteration needs, and sets extrapolated impulses.
  /// Does nothing the second time.
  void complete(const ContactSolverParameters& parameters);
  /// Changes a contact's target after complete().
  void set_target(int contact, const Vector3& target_v);
  /// Whether all bodies that move are slow before the step, and no row acts on them.
  [[nodiscard]] bool is_at_rest() const { return at_rest_; }

  [[nodiscard]] std::span<const int> moving() const { return moving_; }
  [[nodiscard]] std::span<SolverRow> rows() { return rows_; }
  [[nodiscard]] std::span<const SolverRow> rows() const { return rows_; }
  [[nodiscard]] std::span<ContactPack> packs() { return {packs_.data(), index(pack_count_)}; }
  [[nodiscard]] std::span<const ContactPack> packs() const {
    return {packs_.data(), index(pack_count_)};
  }
  /// The packs from `first` on that are of the same two bodies.
  [[nodiscard]] std::span<ContactPack> packs_of_pair(std::size_t first);
  [[nodiscard]] const SolverBody& at(int body) const { return bodies_[index(body)]; }
  [[nodiscard]] SolverBody& at(int body) { return bodies_[index(body)]; }
  /// Null if fixed.
  [[nodiscard]] const SolverBody* find(int body) const {
    return body == kFixed ? nullptr : &at(body);
  }
  /// Number among the bodies that move, or -1.
  [[nodiscard]] int unknown_of(int body) const { return body == kFixed ? -1 : at(body).unknown; }

  /// Adds impulses to the velocities of both bodies.
  void apply_impulse(const ContactPack& pack, const ContactPack::BodyImpulses& impulses);
  /// Sets the last step's impulses.
  void set_last_impulses();
  /// V = V_free + M^-1 J' gamma.
  void velocities_from_impulses();
  /// v_c = J V - target.
  void evaluate_constraint_velocities();
  /// Both of them.
  void update_velocities() {
    velocities_from_impulses();
    evaluate_constraint_velocities();
  }
  /// Leaves the velocities of the impulses in place; return_to_newton_velocities() brings those of
  /// Newton's iterate back.
  [[nodiscard]] ContactResidual residual(const ContactSolverParameters& parameters);
  void return_to_newton_velocities();

  /// Sets the regularization R = compliance + weight * W.
  void set_proximal_weight(double weight, const ContactSolverParameters& parameters);
  /// The present impulses become the proximal point, the present slip the De Saxce correction.
  void update_proximal_point();
  /// The proximal point becomes the iterate, with its velocities.
  void return_to_proximal_point();
  /// mu |v_t| of the present velocities.
  void update_de_saxce_correction();

 private:
  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  void apply_impulse(int body, const Vector3& impulse, const Vector3& moment);
  [[nodiscard]] ContactPack& add_pack();
  [[nodiscard]] double velocity_of(const Side& side) const;
  void complete_contacts(const ContactSolverParameters& parameters);
  void mark_actuated();
  [[nodiscard]] bool are_slow(const ContactSolverParameters& parameters) const;

  std::vector<SolverBody> bodies_;
  std::vector<int> moving_;
  std::vector<SolverRow> rows_;
  std::vector<ContactPack> packs_;  // as many as there ever were
  int pack_count_ = 0;
  std::vector<std::pair<int, int>> locations_;  // by contact: pack and lane
  bool complete_ = false, at_rest_ = false;
};

/// Packs are kept between steps. They are large, and reusing them avoids allocation.
inline ContactPack& ContactProblem::add_pack() {
  if (packs_.size() == index(pack_count_)) packs_.emplace_back();
  return packs_[index(pack_count_++)];
}

inline int ContactProblem::add_contact(const ContactDescription& contact) {
  // Only contacts of one pair share a pack: its lanes then read the same two bodies, and its sums
  // over lanes are the impulses on these.
  const bool joins = pack_count_ > 0 && packs().back().accepts(contact);
  if (!joins) {
    add_pack().begin(contact.a, contact.b);
  }
  packs().back().add(contact);
  locations_.emplace_back(pack_count_ - 1, packs().back().count - 1);
  return static_cast<int>(locations_.size()) - 1;
}

inline std::span<ContactPack> ContactProblem::packs_of_pair(std::size_t first) {
  const auto all = packs();
  std::size_t end = first + 1;
  while (end < all.size() && all[end].a == all[first].a && all[end].b == all[first].b) ++end;
  return all.subspan(first, end - first);
}

inline void ContactProblem::apply_impulse(int body, const Vector3& impulse, const Vector3& moment) {
  if (body != kFixed && at(body).moves()) at(body).apply_impulse(impulse, moment);
}

inline void ContactProblem::apply_impulse(const ContactPack& pack,
                                          const ContactPack::BodyImpulses& impulses) {
  const auto linear = [](const Vector6& of) { return Vector3(of[0], of[1], of[2]); };
  const auto angular = [](const Vector6& of) { return Vector3(of[3], of[4], of[5]); };
  apply_impulse(pack.a, linear(impulses.on_a), angular(impulses.on_a));
  apply_impulse(pack.b, -linear(impulses.against_b), -angular(impulses.against_b));
}

}  // namespace aprsim::physics
