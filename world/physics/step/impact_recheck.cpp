#include "world/physics/step/impact_recheck.hpp"

#include <algorithm>
#include <utility>

#include "world/physics/collision/speculative/speculative_contacts.hpp"
#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {
namespace {

// Difference of displacements in a step [m] from which the new one counts as not searched.
constexpr double kUnsearchedDistance = 1e-4;

/// Whether two contacts are the same feature of one pair.
bool is_same(const ContactConstraint& a, const ContactConstraint& b) {
  constexpr double kSamePlace = 2e-3, kSameSide = 0.9;  // [m], cosine
  const Contact &p = a.contact, &q = b.contact;
  return p.a == q.a && p.b == q.b && a.fixed == b.fixed &&
         (p.p_W - q.p_W).squaredNorm() < kSamePlace * kSamePlace && p.n_W.dot(q.n_W) > kSameSide;
}

}  // namespace

ImpactRecheck::ImpactRecheck(PhysicsModel& model, ContactSearch& search, StepSolver& solver)
    : model_(model), search_(search), solver_(solver) {
  for (auto* motions : {&before_, &departures_, &searched_}) motions->reserve(model.bodies.size());
  known_.reserve(kConstraintCapacity);
  unsearched_.reserve(model.bodies.size());
}

bool ImpactRecheck::may_impact() const {
  // The displacement is scaled to a full step: the answer must be the same in all substeps.
  return std::ranges::any_of(model_.simplification.awake(), [this](int i) {
    const double share = model_.scene.physics.step_s / model_.step_s;
    return share * model_.displacement_m(i) > kImpactDisplacement && !model_.is_held(i);
  });
}

bool ImpactRecheck::add_new_contacts() {
  // The solved velocities are the directions in which bodies depart; the search was made for those
  // of before the step.
  if (!find_departures()) return false;
  searched_.insert(searched_.end(), departures_.begin(), departures_.end());
  // Contacts are searched at the poses before the step, with the velocities after it.
  solver_.undo();
  before_.clear();
  for (const int i : model_.simplification.awake()) {
    before_.push_back({i, model_.body(i).v_com_W, model_.body(i).omega_W});
  }
  apply_departures();
  known_.clear();
  std::swap(known_, model_.constraints);
  search_.find(unsearched_);
  for (const Motion& motion : before_) set_velocity(motion);
  // New contacts, or bodies that the search woke: the step is solved again. Otherwise the solution
  // stands.
  if (add_found() || solver_.awake_set_changed()) return true;
  solver_.redo();
  return false;
}

/// The solved velocities of all bodies; true if one of them was not searched.
bool ImpactRecheck::find_departures() {
  departures_.clear();
  unsearched_.assign(model_.bodies.size(), 1);
  const auto& composites = model_.simplification.composites();
  bool deflected = false;
  for (const int root : model_.simplification.awake_roots()) {
    const FreeBody& body = model_.body(root);
    Motion motion{root, body.body.v_W(), body.body.omega_W()};
    // The rigid body's origin is the centre of mass of the whole composite, the search needs that
    // of the lead.
    motion.v_com_W += motion.omega_W.cross(body.X_WB.linear() * (body.mass.com - body.origin_B));
    double least = difference_m(motion, {root, body.v_com_W, body.omega_W});
    // A velocity that an earlier recheck has covered needs no new search, which bounds the number
    // of rechecks.
    for (const Motion& searched : searched_) {
      if (searched.body == root) least = std::min(least, difference_m(motion, searched));
    }
    deflected = deflected || least > kUnsearchedDistance;
    for (int m = root; m >= 0 && least <= kUnsearchedDistance; m = composites.next(m)) {
      unsearched_[static_cast<std::size_t>(m)] = 0;
    }
    departures_.push_back(motion);
  }
  return deflected;
}

/// Sets these velocities, and those of the bodies merged with them.
void ImpactRecheck::apply_departures() {
  const auto& composites = model_.simplification.composites();
  for (const Motion& motion : departures_) {
    set_velocity(motion);
    const FreeBody& lead = model_.body(motion.body);
    for (int m = composites.next(motion.body); m >= 0; m = composites.next(m)) {
      set_velocity({m, lead.velocity_at(model_.body(m).com_W()), lead.omega_W});
    }
  }
}

/// Adds the new ones to the known contacts; false if there are none.
bool ImpactRecheck::add_found() {
  known_count_ = known_.size();
  for (const ContactConstraint& found : model_.constraints) {
    // Contacts that already have a solution keep their order and impulses; new ones follow behind
    // them.
    const auto end = known_.begin() + static_cast<std::ptrdiff_t>(known_count_);
    const bool is_known = std::any_of(
        known_.begin(), end, [&](const ContactConstraint& other) { return is_same(found, other); });
    if (!is_known) known_.push_back(found);
  }
  std::swap(known_, model_.constraints);
  return model_.constraints.size() > known_count_;
}

/// Sets the velocity that the search uses. The rigid body keeps its own.
void ImpactRecheck::set_velocity(const Motion& motion) {
  FreeBody& free = model_.body(motion.body);
  free.v_com_W = motion.v_com_W;
  free.omega_W = motion.omega_W;
  free.update_bounds();
}

/// Upper bound of the difference of two displacements of any of the body's points in a step.
double ImpactRecheck::difference_m(const Motion& a, const Motion& b) const {
  const double radius = model_.body(a.body).radius_m;
  return model_.step_s * ((a.v_com_W - b.v_com_W).norm() + radius * (a.omega_W - b.omega_W).norm());
}

}  // namespace aprsim::physics
