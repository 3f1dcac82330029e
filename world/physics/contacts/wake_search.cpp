#include "world/physics/contacts/wake_search.hpp"

#include <algorithm>

namespace aprsim::physics {

WakeSearch::WakeSearch(PhysicsModel& model, BodyCollider& collider)
    : model_(model), collider_(collider) {
  found_.reserve(kPairCapacity);
  work_.reserve(model.bodies.size());
  moved_.reserve(model.bodies.size());
}

void WakeSearch::wake_touched() {
  for (int r = 0; r < static_cast<int>(model_.grippers.size()); ++r) wake_at_robot(r);
  wake_at_awake();
}

// ---- sleeping groups

/// A group wakes when a gripper's part is next to one of its bodies, or a link touches one.
void WakeSearch::wake_at_robot(int robot) {
  const auto index = static_cast<std::size_t>(robot);
  const auto& sleeping = model_.simplification.sleeping();
  const auto& arm = model_.arms[index];
  const Aabb reach = model_.grippers[index].parts().bounds().grown(kNear);
  // Groups are collected first: waking changes the list that the loop runs over.
  work_.clear();  // groups
  for (const int group : sleeping.groups()) {
    const Aabb box = sleeping.box(group);
    const bool may = reach.meets(box) || (!arm.shapes().empty() && arm.bounds().meets(box));
    if (may && robot_at_group(robot, group)) work_.push_back(group);
  }
  for (const int group : work_) model_.simplification.wake(group);
}

bool WakeSearch::robot_at_group(int robot, int group) {
  auto& sleeping = model_.simplification.sleeping();
  const auto& gripper = model_.grippers[static_cast<std::size_t>(robot)];
  // A sleeping group's poses are only valid after this update: they follow the belt lazily.
  sleeping.sync_poses(group);
  bool hit = false;
  for (int body = sleeping.first(group); body >= 0 && !hit; body = sleeping.next(body)) {
    const Aabb& bounds = model_.body(body).bounds;
    for (int p = 0; p < GripperParts::kColliding; ++p) {
      hit = hit || gripper.parts().part(p).bounds.grown(kNear).meets(bounds);
    }
    for (const auto& shape : model_.arms[static_cast<std::size_t>(robot)].shapes()) {
      if (hit || !shape.bounds.meets(bounds)) continue;
      collider_.link_on_free(shape, kGround, body, found_);
      hit = !found_.empty();
      found_.clear();
    }
  }
  return hit;
}

/// The list of awake bodies grows while it is gone through, by those that have been woken.
void WakeSearch::wake_at_awake() {
  const auto& sleeping = model_.simplification.sleeping();
  if (sleeping.groups().empty()) return;
  const auto awake = model_.simplification.awake();
  work_.assign(awake.begin(), awake.end());
  for (std::size_t next = 0; next < work_.size(); ++next) {
    const int body = work_[next];
    // Breadth-first: a woken body is appended, and may wake further groups.
    const auto groups = sleeping.groups();
    // Backwards, for the list shrinks.
    for (std::size_t k = groups.size(); k > 0; --k) {
      const int group = groups[k - 1];
      if (!model_.body(body).bounds.meets(sleeping.box(group)) || !touches_group(body, group)) {
        continue;
      }
      for (int b = sleeping.first(group); b >= 0; b = sleeping.next(b)) work_.push_back(b);
      model_.simplification.wake(group);
    }
  }
}

bool WakeSearch::touches_group(int body, int group) {
  auto& sleeping = model_.simplification.sleeping();
  sleeping.sync_poses(group);
  for (int b = sleeping.first(group); b >= 0; b = sleeping.next(b)) {
    if (!model_.body(body).bounds.meets(model_.body(b).bounds)) continue;
    collider_.free_on_free(body, b, found_);
    if (found_.empty()) continue;
    found_.clear();
    return true;
  }
  return false;
}

// ---- faults

bool WakeSearch::disturb_near_faults() {
  bool changed = false;
  // A fault is a penetration beyond kFaultDepth. The bodies will be pushed apart fast, and may hit
  // sleeping neighbours that the search has left out.
  for (const auto& constraint : model_.constraints) {
    if (!is_fault(constraint, model_.ids)) continue;
    for (const int body : {constraint.contact.a, constraint.contact.b}) {
      if (model_.ids.is_free(body)) changed = disturb_near(body) || changed;
    }
  }
  return changed;
}

bool WakeSearch::disturb_near(int faulty) {
  auto& simplification = model_.simplification;
  const Aabb reach = model_.body(faulty).bounds.grown(kNear);
  const bool woken = wake_in(reach);
  work_.clear();  // roots of the composites there
  for (const int body : simplification.awake()) {
    if (reach.meets(model_.body(body).bounds)) work_.push_back(simplification.root(body));
  }
  moved_.clear();  // all their members
  for (const int body : simplification.awake()) {
    const auto root = simplification.root(body);
    if (std::find(work_.begin(), work_.end(), root) != work_.end()) moved_.push_back(body);
  }
  bool freed = false;
  for (const int body : moved_) {
    freed = freed || simplification.composites().parent(body) >= 0;
    simplification.disturb(body);
  }
  return woken || freed;
}

/// Wakes the groups with a body in that box. True if there were any.
bool WakeSearch::wake_in(const Aabb& reach) {
  auto& sleeping = model_.simplification.sleeping();
  work_.clear();  // groups
  for (const int group : sleeping.groups()) {
    if (!reach.meets(sleeping.box(group))) continue;
    sleeping.sync_poses(group);
    bool in = false;
    for (int b = sleeping.first(group); b >= 0 && !in; b = sleeping.next(b)) {
      in = reach.meets(model_.body(b).bounds);
    }
    if (in) work_.push_back(group);
  }
  for (const int group : work_) model_.simplification.wake(group);
  return !work_.empty();
}

}  // namespace aprsim::physics
