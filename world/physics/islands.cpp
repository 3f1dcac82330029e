#include "world/physics/islands.hpp"

#include <algorithm>

#include "world/physics/constraint/mixed_lcp.hpp"

namespace aprsim::physics {
namespace {

constexpr int kContactRows = 3;
constexpr int kJointRows = 6;
// Above this an exact solve costs more than a step has; the island falls back to the iterative one.
constexpr int kMaxGripperRows = 150;
static_assert(kMaxGripperRows <= MixedLcp::kCapacity);
// A few bodies on a carrier: the direct solver is exact and cheaper. Piles (gears loose in a tray)
// are redundant, where it may take milliseconds.
constexpr int kMaxDirectRows = 60;

}  // namespace

Islands::Islands(const PhysicsModel& model)
    : ids_(model.ids),
      free_(model.ids.free_count()),
      count_(free_ + static_cast<int>(model.grippers.size())),
      near_(index(count_)),
      parent_(index(count_)),
      island_of_(index(free_)),
      number_(index(count_)),
      sums_(index(count_)),
      phase_(index(count_)) {}

int Islands::node(const PhysicsModel& model, BodyIndex body) const {
  if (body < 0 || ids_.is_link(body)) return -1;
  return ids_.is_free(body) ? model.simplification.root(body) : free_ + ids_.robot_of(body);
}

/// Union-find: the lowest node of a component, with path halving.
int Islands::root(int node) {
  while (parent_[index(node)] != node) {
    parent_[index(node)] = parent_[index(parent_[index(node)])];
    node = parent_[index(node)];
  }
  return node;
}

void Islands::unite(int a, int b) {
  const int ra = root(a), rb = root(b);
  parent_[index(std::max(ra, rb))] = std::min(ra, rb);
}

void Islands::find(const PhysicsModel& model, std::span<ContactConstraint> constraints) {
  mark_near(model, constraints);
  // Components over all edges that are not cut.
  for_nodes(model, [this](int i) {
    parent_[index(i)] = i;
    sums_[index(i)] = {};
  });
  for (auto& constraint : constraints) {
    const int a = node(model, constraint.contact.a), b = node(model, constraint.contact.b);
    constraint.cut = a >= 0 && b >= 0 && (near_[index(a)] == kFar) != (near_[index(b)] == kFar);
    if (a >= 0 && b >= 0 && !constraint.cut) unite(a, b);
  }
  for (const auto& pair : model.simplification.joined_pairs()) unite(pair.a, pair.b);
  sum_up(model, constraints);
  choose_phases(model);
  // Where a gripper's island is solved iteratively after all, nothing is solved before the rest.
  for (auto& constraint : constraints) {
    if (!constraint.cut) continue;
    const int a = node(model, constraint.contact.a), b = node(model, constraint.contact.b);
    const int near = near_[index(a)] == kFar ? b : a;
    if (phase_of_node(near) == Phase::kIterative) constraint.cut = false;
  }
}

/// The cheapest solver that is exact enough for the island.
void Islands::choose_phases(const PhysicsModel& model) {
  any_ = {};
  oversized_ = 0;
  for_nodes(model, [&](int i) {
    const Sum& sum = sums_[index(root(i))];
    Phase phase = Phase::kIterative;
    if (i >= free_ && model.grippers[index(i - free_)].idle()) {
      phase = Phase::kNone;
    } else if (sum.gripper) {
      if (sum.rows <= kMaxGripperRows) {
        phase = sum.foreign ? Phase::kCoupled : Phase::kDecoupled;
      } else if (root(i) == i) {
        ++oversized_;
      }
    } else if (sum.rows <= kMaxDirectRows && !sum.pile) {
      phase = Phase::kDirect;
    }
    phase_[index(i)] = phase;
    number_[index(i)] = root(i);
    any_[static_cast<std::size_t>(phase)] = true;
    if (i < free_) island_of_[index(i)] = near_[index(i)] == kFar ? root(i) : -1;
  });
}

/// Floods from each gripper through contacts; trays and the bodies joined to them are the border,
/// beyond which the flood does not go.
void Islands::mark_near(const PhysicsModel& model, std::span<ContactConstraint> constraints) {
  for_nodes(model, [this](int i) { near_[index(i)] = i < free_ ? kFar : kCore; });
  if (free_ == count_) return;
  const auto reach = [&](int from, int to) {
    if (near_[index(from)] != kCore || near_[index(to)] != kFar) return false;
    near_[index(to)] = to < free_ && model.body(to).is_tray() ? kBorder : kCore;
    return true;
  };
  bool changed = true;
  while (changed) {
    changed = false;
    for (const auto& constraint : constraints) {
      const int a = node(model, constraint.contact.a), b = node(model, constraint.contact.b);
      if (a < 0 || b < 0) continue;
      changed = reach(a, b) || changed;
      changed = reach(b, a) || changed;
    }
    for (const auto& pair : model.simplification.joined_pairs()) {
      if ((near_[index(pair.a)] == kFar) == (near_[index(pair.b)] == kFar)) continue;
      near_[index(near_[index(pair.a)] == kFar ? pair.a : pair.b)] = kBorder;
      changed = true;
    }
  }
}

/// Rows and kinds of contacts of each island.
void Islands::sum_up(const PhysicsModel& model, std::span<const ContactConstraint> constraints) {
  for (const auto& constraint : constraints) {
    const auto& contact = constraint.contact;
    const int a = node(model, contact.a), b = node(model, contact.b);
    // A cut contact counts for the far side, where it is solved.
    const int owner = !constraint.cut || near_[index(a)] == kFar ? a : b;
    Sum& sum = sums_[index(root(owner))];
    sum.rows += kContactRows;
    sum.foreign = sum.foreign || contact.pair != SurfacePair::kPadGear;
    sum.pile = sum.pile || contact.pair == SurfacePair::kGearTray;
  }
  for (const auto& pair : model.simplification.joined_pairs()) {
    sums_[index(root(pair.a))].rows += kJointRows;
  }
  // A gripper makes the island its own, touching or not.
  for (int r = free_; r < count_; ++r) {
    Sum& sum = sums_[index(root(r))];
    sum.gripper = true;
    sum.rows += model.grippers[index(r - free_)].rows();
  }
}

int Islands::number_of(const PhysicsModel& model, const ContactConstraint& constraint) const {
  const int a = node(model, constraint.contact.a);
  return number_[index(a >= 0 ? a : node(model, constraint.contact.b))];
}

Phase Islands::phase_of(const PhysicsModel& model, const ContactConstraint& constraint) const {
  const int a = node(model, constraint.contact.a), b = node(model, constraint.contact.b);
  if (constraint.cut) return Phase::kIterative;
  return phase_of_node(a >= 0 ? a : b);
}

}  // namespace aprsim::physics
