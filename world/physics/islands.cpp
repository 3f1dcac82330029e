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

Islands::Islands(const Cell& cell)
    : nodes_(cell.nodes),
      free_(cell.nodes.free_count()),
      count_(free_ + static_cast<int>(cell.grippers.size())),
      near_(index(count_)),
      parent_(index(count_)),
      island_of_(index(free_)),
      sums_(index(count_)),
      phase_(index(count_)) {}

int Islands::node(BodyIndex body) const {
  if (body < 0 || nodes_.is_link(body)) return -1;
  return nodes_.is_free(body) ? body : free_ + nodes_.robot_of(body);
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

void Islands::find(const Cell& cell, std::span<Touch> touches) {
  mark_near(cell, touches);
  for (int i = 0; i < count_; ++i) {
    parent_[index(i)] = i;
    sums_[index(i)] = {};
  }
  for (auto& touch : touches) {
    const int a = node(touch.contact.a), b = node(touch.contact.b);
    touch.cut = a >= 0 && b >= 0 && (near_[index(a)] == kFar) != (near_[index(b)] == kFar);
    if (a >= 0 && b >= 0 && !touch.cut) unite(a, b);
  }
  for (int gear = 0; gear < free_; ++gear) {
    const int tray = cell.simplification.joined_to(gear);
    if (tray >= 0 && !cell.simplification.parked(gear)) unite(gear, tray);
  }
  sum_up(cell, touches);
  for (int i = 0; i < count_; ++i) {
    const Sum& sum = sums_[index(root(i))];
    const bool solved =
        i < free_ ? !cell.simplification.parked(i) : !cell.grippers[index(i - free_)].idle();
    Phase phase = Phase::kIterative;
    if (!solved) {
      phase = Phase::kNone;
    } else if (sum.gripper) {
      if (sum.rows <= kMaxGripperRows) phase = sum.foreign ? Phase::kFixedFriction : Phase::kDirect;
    } else if (sum.rows <= kMaxQuietRows && !sum.pile) {
      phase = Phase::kDirect;
    }
    phase_[index(i)] = phase;
    if (i < free_) island_of_[index(i)] = solved && near_[index(i)] == kFar ? root(i) : -1;
  }
  // Where a gripper's island is solved iteratively after all, nothing is solved before the rest.
  for (auto& touch : touches) {
    if (!touch.cut) continue;
    const int a = node(touch.contact.a), b = node(touch.contact.b);
    const int near = near_[index(a)] == kFar ? b : a;
    if (phase_of_node(near) == Phase::kIterative) touch.cut = false;
  }
}

/// Floods from each gripper through what it touches; trays and what is joined to them are the
/// border, beyond which the flood does not go.
void Islands::mark_near(const Cell& cell, std::span<Touch> touches) {
  std::fill(near_.begin(), near_.end(), kFar);
  for (int r = free_; r < count_; ++r) near_[index(r)] = kCore;
  const auto reach = [&](int from, int to) {
    if (near_[index(from)] != kCore || near_[index(to)] != kFar) return false;
    near_[index(to)] = to < free_ && cell.body(to).is_tray() ? kBorder : kCore;
    return true;
  };
  bool changed = true;
  while (changed) {
    changed = false;
    for (const auto& touch : touches) {
      const int a = node(touch.contact.a), b = node(touch.contact.b);
      if (a < 0 || b < 0) continue;
      changed = reach(a, b) || changed;
      changed = reach(b, a) || changed;
    }
    for (int gear = 0; gear < free_; ++gear) {
      const int tray = cell.simplification.joined_to(gear);
      if (tray < 0 || (near_[index(tray)] == kFar) == (near_[index(gear)] == kFar)) continue;
      const int far = near_[index(tray)] == kFar ? tray : gear;
      near_[index(far)] = kBorder;
      changed = true;
    }
  }
}

void Islands::sum_up(const Cell& cell, std::span<const Touch> touches) {
  for (const auto& touch : touches) {
    const auto& contact = touch.contact;
    const int a = node(contact.a), b = node(contact.b);
    // A cut touch counts for the far side, where it is solved.
    const int owner = !touch.cut || near_[index(a)] == kFar ? a : b;
    Sum& sum = sums_[index(root(owner))];
    sum.rows += kContactRows;
    sum.foreign = sum.foreign || contact.pair != SurfacePair::kPadGear;
    sum.pile = sum.pile || contact.pair == SurfacePair::kGearTray;
  }
  for (int gear = 0; gear < free_; ++gear) {
    if (cell.simplification.joined_to(gear) >= 0) sums_[index(root(gear))].rows += kJointRows;
  }
  for (int r = free_; r < count_; ++r) {
    Sum& sum = sums_[index(root(r))];
    sum.gripper = true;
    sum.rows += cell.grippers[index(r - free_)].rows();
  }
}

Phase Islands::phase_of(const Touch& touch) const {
  const int a = node(touch.contact.a), b = node(touch.contact.b);
  if (touch.cut) return Phase::kIterative;
  return phase_of_node(a >= 0 ? a : b);
}

bool Islands::any(Phase phase) const {
  return std::find(phase_.begin(), phase_.end(), phase) != phase_.end();
}

}  // namespace aprsim::physics
