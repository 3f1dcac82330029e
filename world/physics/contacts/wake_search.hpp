#pragma once

#include <vector>

#include "world/physics/contacts/body_collider.hpp"

namespace aprsim::physics {

/// Wakes sleeping groups and unmerges bodies near a robot, an awake body or a faulty contact. No
/// call allocates after warm-up. The order is fixed by body numbers.
class WakeSearch {
 public:
  // Distance within which a gripper's part or a faulty body is near another one [m]: more than its
  // displacement in a step.
  static constexpr double kNear = 2e-3;

  WakeSearch(PhysicsModel& model, BodyCollider& collider);

  /// Wakes the groups that robots are at, those that awake bodies touch, and those that the woken
  /// ones touch.
  void wake_touched();
  /// Bodies that penetrate deeply are pushed apart and may hit their neighbours in the coming step.
  /// Groups near them wake, composites are unmerged. True if there were any.
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
  std::vector<Contact> found_;  // of the present pair
  std::vector<int> work_, moved_;
};

}  // namespace aprsim::physics
