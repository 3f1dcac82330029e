#include "world/physics/step/blow_search.hpp"

#include <algorithm>
#include <utility>

#include "world/physics/collision/speculative/look_ahead.hpp"
#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {
namespace {

// A blow leads off the way that was looked at when it is farther from it than that [m in a step].
constexpr double kOffTheWay = 1e-4;

/// Do two contacts of one pair stand for the same touch?
bool is_same(const ContactConstraint& a, const ContactConstraint& b) {
  constexpr double kSamePlace = 2e-3, kSameSide = 0.9;  // [m], cosine
  const Contact &p = a.contact, &q = b.contact;
  return p.a == q.a && p.b == q.b && a.fixed == b.fixed &&
         (p.p_W - q.p_W).squaredNorm() < kSamePlace * kSamePlace && p.n_W.dot(q.n_W) > kSameSide;
}

}  // namespace

BlowSearch::BlowSearch(PhysicsModel& model, ContactSearch& search, StepSolver& solver)
    : model_(model), search_(search), solver_(solver) {
  for (auto* motions : {&before_, &leaving_, &looked_at_}) motions->reserve(model.bodies.size());
  known_.reserve(kConstraintCapacity);
  off_the_way_.reserve(model.bodies.size());
}

bool BlowSearch::strikes() const {
  // The displacement is scaled to a full step: the answer must be the same in all substeps.
  return std::ranges::any_of(model_.simplification.awake(), [this](int i) {
    const double share = model_.scene.physics.step_s / model_.step_s;
    return share * model_.way_m(i) > kStrikingWay && !model_.is_held(i);
  });
}

bool BlowSearch::add_met() {
  // The solved velocities are the directions in which bodies depart; the search was made for those
  // of before the step.
  if (!find_leaving()) return false;
  looked_at_.insert(looked_at_.end(), leaving_.begin(), leaving_.end());
  // Contacts are searched at the poses before the step, with the velocities after it.
  solver_.undo();
  before_.clear();
  for (const int i : model_.simplification.awake()) {
    before_.push_back({i, model_.body(i).v_com_W, model_.body(i).omega_W});
  }
  move_as_leaving();
  known_.clear();
  std::swap(known_, model_.constraints);
  search_.find(off_the_way_);
  for (const Motion& motion : before_) set_velocity(motion);
  // New contacts, or bodies that the search woke: the step is solved again. Otherwise the solution
  // stands.
  if (add_found() || solver_.others_awake()) return true;
  solver_.redo();
  return false;
}

/// The velocities that bodies would leave with; true where one of them is news.
bool BlowSearch::find_leaving() {
  leaving_.clear();
  off_the_way_.assign(model_.bodies.size(), 1);
  const auto& composites = model_.simplification.composites();
  bool blow = false;
  for (const int root : model_.simplification.awake_roots()) {
    const FreeBody& body = model_.body(root);
    Motion motion{root, body.body.v_W(), body.body.omega_W()};
    // The rigid body's origin is the centre of mass of the whole composite, the search needs that
    // of the lead.
    motion.v_com_W += motion.omega_W.cross(body.X_WB.linear() * (body.mass.com - body.origin_B));
    double least = apart_m(motion, {root, body.v_com_W, body.omega_W});
    // A velocity that an earlier recheck has covered needs no new search, which bounds the number
    // of rechecks.
    for (const Motion& looked : looked_at_) {
      if (looked.body == root) least = std::min(least, apart_m(motion, looked));
    }
    blow = blow || least > kOffTheWay;
    for (int m = root; m >= 0 && least <= kOffTheWay; m = composites.next(m)) {
      off_the_way_[static_cast<std::size_t>(m)] = 0;
    }
    leaving_.push_back(motion);
  }
  return blow;
}

/// With them what is merged with these bodies.
void BlowSearch::move_as_leaving() {
  const auto& composites = model_.simplification.composites();
  for (const Motion& motion : leaving_) {
    set_velocity(motion);
    const FreeBody& lead = model_.body(motion.body);
    for (int m = composites.next(motion.body); m >= 0; m = composites.next(m)) {
      set_velocity({m, lead.velocity_at(model_.body(m).com_W()), lead.omega_W});
    }
  }
}

/// To the contacts that were known; false where none is news.
bool BlowSearch::add_found() {
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

/// For the search alone: its rigid body keeps its own.
void BlowSearch::set_velocity(const Motion& motion) {
  FreeBody& free = model_.body(motion.body);
  free.v_com_W = motion.v_com_W;
  free.omega_W = motion.omega_W;
  free.update_bounds();
}

/// Of any of the body's points in a step, at most.
double BlowSearch::apart_m(const Motion& a, const Motion& b) const {
  const double radius = model_.body(a.body).radius_m;
  return model_.step_s * ((a.v_com_W - b.v_com_W).norm() + radius * (a.omega_W - b.omega_W).norm());
}

}  // namespace aprsim::physics
