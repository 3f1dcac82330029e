#include <algorithm>

#include "world/physics/contact_search.hpp"

namespace aprsim::physics {

// ---- dormant groups

/// A group wakes when a gripper's part is next to one of its bodies, or a link touches one.
void ContactSearch::wake_near_robot(int robot) {
  const auto index = static_cast<std::size_t>(robot);
  const auto& simplification = cell_.simplification;
  const auto& arm = cell_.arms[index];
  const Bounds reach = gripper_bounds_[index].grown(kNear);
  work_.clear();
  for (const int group : simplification.dormancy().groups()) {
    const Bounds box = simplification.dormancy().box(group);
    const bool may = reach.meets(box) || (!arm.shapes().empty() && arm.bounds().meets(box));
    if (may && robot_at_group(robot, group)) work_.push_back(group);
  }
  for (const int group : work_) cell_.simplification.wake(group);
}

bool ContactSearch::robot_at_group(int robot, int group) {
  auto& dormancy = cell_.simplification.dormancy();
  dormancy.sync_poses(group);
  bool hit = false;
  for (int body = dormancy.first(group); body >= 0 && !hit; body = dormancy.next(body)) {
    const Bounds& bounds = cell_.body(body).bounds;
    for (int p = 0; p < kParts; ++p) {
      hit = hit || part(robot, p).bounds.grown(kNear).meets(bounds);
    }
    for (const auto& shape : cell_.arms[static_cast<std::size_t>(robot)].shapes()) {
      if (hit || !shape.bounds.meets(bounds)) continue;
      link_points(shape, body, kGround);
      hit = !found_.empty();
      found_.clear();
    }
  }
  return hit;
}

/// Wakes the groups that awake bodies touch, and those that the woken ones touch.
void ContactSearch::wake_touched() {
  const auto& dormancy = cell_.simplification.dormancy();
  if (dormancy.groups().empty()) return;
  const auto awake = cell_.simplification.awake();
  work_.assign(awake.begin(), awake.end());
  for (std::size_t next = 0; next < work_.size(); ++next) {
    const int body = work_[next];
    const auto groups = dormancy.groups();
    for (std::size_t k = groups.size(); k > 0; --k) {
      const int group = groups[k - 1];
      if (!cell_.body(body).bounds.meets(dormancy.box(group)) || !touches_group(body, group)) {
        continue;
      }
      for (int b = dormancy.first(group); b >= 0; b = dormancy.next(b)) work_.push_back(b);
      cell_.simplification.wake(group);
    }
  }
}

bool ContactSearch::touches_group(int body, int group) {
  auto& dormancy = cell_.simplification.dormancy();
  dormancy.sync_poses(group);
  for (int b = dormancy.first(group); b >= 0; b = dormancy.next(b)) {
    if (cell_.body(body).bounds.meets(cell_.body(b).bounds)) free_on_free(body, b);
    if (found_.empty()) continue;
    found_.clear();
    return true;
  }
  return false;
}

// ---- faults

/// Bodies thrown out of each other may hit what lies next to them in the coming step: groups there
/// wake, composites there come apart. True if some did.
bool ContactSearch::disturb_near_faults() {
  bool changed = false;
  for (const auto& touch : cell_.touches) {
    if (!is_fault(touch, cell_.nodes)) continue;
    for (const int body : {touch.contact.a, touch.contact.b}) {
      if (cell_.nodes.is_free(body)) changed = disturb_near(body) || changed;
    }
  }
  return changed;
}

bool ContactSearch::disturb_near(int faulty) {
  auto& simplification = cell_.simplification;
  const Bounds reach = cell_.body(faulty).bounds.grown(kNear);
  const bool woken = wake_in(reach);
  work_.clear();  // solids
  for (const int body : simplification.awake()) {
    if (reach.meets(cell_.body(body).bounds)) work_.push_back(simplification.root(body));
  }
  released_.clear();  // all that moves with them
  for (const int body : simplification.awake()) {
    const auto root = simplification.root(body);
    if (std::find(work_.begin(), work_.end(), root) != work_.end()) released_.push_back(body);
  }
  bool freed = false;
  for (const int body : released_) {
    freed = freed || simplification.composites().parent(body) >= 0;
    simplification.disturb(body);
  }
  return woken || freed;
}

/// Wakes the groups with a body in that box. True if there were any.
bool ContactSearch::wake_in(const Bounds& reach) {
  auto& dormancy = cell_.simplification.dormancy();
  work_.clear();
  for (const int group : dormancy.groups()) {
    if (!reach.meets(dormancy.box(group))) continue;
    dormancy.sync_poses(group);
    bool in = false;
    for (int b = dormancy.first(group); b >= 0 && !in; b = dormancy.next(b)) {
      in = reach.meets(cell_.body(b).bounds);
    }
    if (in) work_.push_back(group);
  }
  for (const int group : work_) cell_.simplification.wake(group);
  return !work_.empty();
}

}  // namespace aprsim::physics
