#pragma once

#include <vector>

#include "world/physics/contacts/body_collider.hpp"

namespace aprsim::physics {

/// Wakes what sleeps and parts what is merged where something comes to it: a robot, an awake body,
/// or bodies in a fault. No call allocates after warm-up. The order is fixed by body numbers.
class WakeSearch {
 public:
  // A gripper's part or a faulty body counts as next to another within this [m]: more than it moves
  // in a step.
  static constexpr double kNear = 2e-3;

  WakeSearch(PhysicsModel& model, BodyCollider& collider);

  /// Wakes the groups that robots are at, those that awake bodies touch, and those that the woken
  /// ones touch.
  void wake_touched();
  /// Bodies thrown out of each other may hit what lies next to them in the coming step: groups
  /// there wake, composites there come apart. True if some did.
  bool disturb_near_faults();

 private:
  void wake_at_robot(int robot);
  [[nodiscard]] bool robot_at_group(int robot, int group);
  void wake_at_awake();
  [[nodiscard]] bool touches_group(int body, int group);
  bool disturb_near(int faulty);
  bool wake_in(const Aabb& reach);

  PhysicsModel& model_;
  BodyCollider& collider_;
  std::vector<Contact> found_;  // of the pair at hand
  std::vector<int> work_, moved_;
};

}  // namespace aprsim::physics
