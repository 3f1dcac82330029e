#include "world/physics/step/islands.hpp"

#include <algorithm>

namespace aprsim::physics {

Islands::Islands(const PhysicsModel& model)
    : ids_(model.ids),
      free_(model.ids.free_count()),
      count_(free_ + static_cast<int>(model.grippers.size())),
      near_(index(count_)),
      parent_(index(count_)),
      together_(index(free_)),
      number_(index(count_)) {}

int Islands::node(const PhysicsModel& model, BodyIndex body) const {
  if (body < 0 || ids_.is_link(body)) return -1;
  return ids_.is_free(body) ? model.simplification.root(body) : free_ + ids_.robot_of(body);
}

/// Union-find: the lowest node of a component, with path halving.
/// Path halving: every visited node is linked to its grandparent (Tarjan & van Leeuwen 1984).
int Islands::root(int node) {
  while (parent_[index(node)] != node) {
    parent_[index(node)] = parent_[index(parent_[index(node)])];
    node = parent_[index(node)];
  }
  return node;
}

void Islands::unite(int a, int b) {
  // The lower root wins. Island numbers thus do not depend on the order of the contacts.
  const int ra = root(a), rb = root(b);
  parent_[index(std::max(ra, rb))] = std::min(ra, rb);
}

void Islands::find(const PhysicsModel& model, std::span<const ContactConstraint> constraints) {
  // Two partitions from one union-find: resting groups end at a gripper's surroundings, islands of
  // the solver do not.
  mark_near(model, constraints);
  for_nodes(model, [this](int i) { parent_[index(i)] = i; });
  for_edges(model, constraints, [this](int a, int b) {
    // Edges across the border of a gripper's surroundings are left out first, and added for the
    // islands afterwards.
    if ((near_[index(a)] == kFar) == (near_[index(b)] == kFar)) unite(a, b);
  });
  for (const int i : model.simplification.awake_roots()) {
    together_[index(i)] = near_[index(i)] == kFar ? root(i) : -1;
  }
  const bool grippers = free_ < count_;
  if (grippers) for_edges(model, constraints, [this](int a, int b) { unite(a, b); });
  for_nodes(model, [this](int i) { number_[index(i)] = root(i); });
}

/// Floods from each gripper through contacts; trays and the bodies joined to them are the border,
/// beyond which the flood does not go.
void Islands::mark_near(const PhysicsModel& model, std::span<const ContactConstraint> constraints) {
  for_nodes(model, [this](int i) { near_[index(i)] = i < free_ ? kFar : kCore; });
  if (free_ == count_) return;
  const auto reach = [&](int from, int to) {
    if (near_[index(from)] != kCore || near_[index(to)] != kFar) return false;
    near_[index(to)] = to < free_ && model.body(to).is_tray() ? kBorder : kCore;
    return true;
  };
  // Few bodies are near a gripper, so that sweeps to a fixed point are cheaper than a queue.
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

int Islands::number_of(const PhysicsModel& model, const ContactConstraint& constraint) const {
  const int a = node(model, constraint.contact.a);
  return number_[index(a >= 0 ? a : node(model, constraint.contact.b))];
}

}  // namespace aprsim::physics
