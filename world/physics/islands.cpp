#include "world/physics/islands.hpp"

#include <algorithm>

namespace aprsim::physics {
namespace {

constexpr int kContactRows = 3;
constexpr int kJointRows = 6;
// Above this a direct solve costs more than a step has; the island falls back to the iterative one.
constexpr int kMaxGripperRows = 150;
// A few bodies on a support: the direct solver is exact and cheaper. Piles (gears loose in a tray)
// are redundant, where it may take milliseconds.
constexpr int kMaxQuietRows = 60;

}  // namespace

Islands::Islands(const PhysicsModel& cell)
    : nodes_(cell.nodes),
      free_(cell.nodes.free_count()),
      count_(free_ + static_cast<int>(cell.grippers.size())),
      near_(index(count_)),
      parent_(index(count_)),
      island_of_(index(free_)),
      number_(index(count_)),
      sums_(index(count_)),
      phase_(index(count_)) {}

int Islands::node(const PhysicsModel& cell, BodyIndex body) const {
  if (body < 0 || nodes_.is_link(body)) return -1;
  return nodes_.is_free(body) ? cell.simplification.root(body) : free_ + nodes_.robot_of(body);
}

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

void Islands::find(const PhysicsModel& cell, std::span<ContactConstraint> touches) {
  mark_near(cell, touches);
  for_nodes(cell, [this](int i) {
    parent_[index(i)] = i;
    sums_[index(i)] = {};
  });
  for (auto& touch : touches) {
    const int a = node(cell, touch.contact.a), b = node(cell, touch.contact.b);
    touch.cut = a >= 0 && b >= 0 && (near_[index(a)] == kFar) != (near_[index(b)] == kFar);
    if (a >= 0 && b >= 0 && !touch.cut) unite(a, b);
  }
  for (const auto& pair : cell.simplification.joined_pairs()) unite(pair.a, pair.b);
  sum_up(cell, touches);
  choose_phases(cell);
  // Where a gripper's island is solved iteratively after all, nothing is solved before the rest.
  for (auto& touch : touches) {
    if (!touch.cut) continue;
    const int a = node(cell, touch.contact.a), b = node(cell, touch.contact.b);
    const int near = near_[index(a)] == kFar ? b : a;
    if (phase_of_node(near) == Phase::kIterative) touch.cut = false;
  }
}

void Islands::choose_phases(const PhysicsModel& cell) {
  any_ = {};
  for_nodes(cell, [&](int i) {
    const Sum& sum = sums_[index(root(i))];
    Phase phase = Phase::kIterative;
    if (i >= free_ && cell.grippers[index(i - free_)].idle()) {
      phase = Phase::kNone;
    } else if (sum.gripper) {
      if (sum.rows <= kMaxGripperRows) phase = sum.foreign ? Phase::kCoupled : Phase::kDecoupled;
    } else if (sum.rows <= kMaxQuietRows && !sum.pile) {
      phase = Phase::kDirect;
    }
    phase_[index(i)] = phase;
    number_[index(i)] = root(i);
    any_[static_cast<std::size_t>(phase)] = true;
    if (i < free_) island_of_[index(i)] = near_[index(i)] == kFar ? root(i) : -1;
  });
}

/// Floods from each gripper through what it touches; trays and what is joined to them are the
/// border, beyond which the flood does not go.
void Islands::mark_near(const PhysicsModel& cell, std::span<ContactConstraint> touches) {
  for_nodes(cell, [this](int i) { near_[index(i)] = i < free_ ? kFar : kCore; });
  if (free_ == count_) return;
  const auto reach = [&](int from, int to) {
    if (near_[index(from)] != kCore || near_[index(to)] != kFar) return false;
    near_[index(to)] = to < free_ && cell.body(to).is_tray() ? kBorder : kCore;
    return true;
  };
  bool changed = true;
  while (changed) {
    changed = false;
    for (const auto& touch : touches) {
      const int a = node(cell, touch.contact.a), b = node(cell, touch.contact.b);
      if (a < 0 || b < 0) continue;
      changed = reach(a, b) || changed;
      changed = reach(b, a) || changed;
    }
    for (const auto& pair : cell.simplification.joined_pairs()) {
      if ((near_[index(pair.a)] == kFar) == (near_[index(pair.b)] == kFar)) continue;
      near_[index(near_[index(pair.a)] == kFar ? pair.a : pair.b)] = kBorder;
      changed = true;
    }
  }
}

void Islands::sum_up(const PhysicsModel& cell, std::span<const ContactConstraint> touches) {
  for (const auto& touch : touches) {
    const auto& contact = touch.contact;
    const int a = node(cell, contact.a), b = node(cell, contact.b);
    // A cut touch counts for the far side, where it is solved.
    const int owner = !touch.cut || near_[index(a)] == kFar ? a : b;
    Sum& sum = sums_[index(root(owner))];
    sum.rows += kContactRows;
    sum.foreign = sum.foreign || contact.pair != SurfacePair::kPadGear;
    sum.pile = sum.pile || contact.pair == SurfacePair::kGearTray;
  }
  for (const auto& pair : cell.simplification.joined_pairs()) {
    sums_[index(root(pair.a))].rows += kJointRows;
  }
  for (int r = free_; r < count_; ++r) {
    Sum& sum = sums_[index(root(r))];
    sum.gripper = true;
    sum.rows += cell.grippers[index(r - free_)].rows();
  }
}

int Islands::number_of(const PhysicsModel& cell, const ContactConstraint& touch) const {
  const int a = node(cell, touch.contact.a);
  return number_[index(a >= 0 ? a : node(cell, touch.contact.b))];
}

Phase Islands::phase_of(const PhysicsModel& cell, const ContactConstraint& touch) const {
  const int a = node(cell, touch.contact.a), b = node(cell, touch.contact.b);
  if (touch.cut) return Phase::kIterative;
  return phase_of_node(a >= 0 ? a : b);
}

}  // namespace aprsim::physics
