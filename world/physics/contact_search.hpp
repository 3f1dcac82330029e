#pragma once

#include <span>
#include <utility>
#include <vector>

#include "world/physics/physics_model.hpp"

namespace aprsim::physics {

/// Finds the contacts of a step: broadphase over tight axis-aligned boxes, exact geometry from
/// contact_generation.hpp, links by ODE's primitives. Dormant groups are only looked at where
/// something that moves is in their box; whatever touches them wakes them, and frees merged bodies,
/// in the same step, and so does a fault next to them. No call allocates after warm-up. The order
/// is fixed by body numbers.
class ContactSearch {
 public:
  explicit ContactSearch(PhysicsModel& cell);

  /// Fills cell.touches.
  void find();
  /// Releases merged bodies from their parents and adds their contacts with these.
  void release(std::span<const int> members);

 private:
  // A gripper's part or a faulty body counts as next to another within this [m]: more than it moves
  // in a step.
  static constexpr double kNear = 2e-3;
  // How far a closing pad, and what it presses on its support, are looked ahead [m], so that they
  // do not get stuck in each other first: a finger moves 0.3 mm in a step, a gear tips by less.
  static constexpr double kPadAhead = 4e-4, kSinkAhead = 5e-5;
  static constexpr int kParts = 3;  // of a gripper: palm and two fingers

  void search();
  bool disturb_near_faults();
  bool disturb_near(int faulty);
  bool wake_in(const Bounds& reach);
  void find_for_robot(int robot);
  void gripper_on_free(int robot, int part, int body);
  void gripper_on_fixed(int robot, int part);
  void gripper_on_robots(int robot, int part);
  void link_on_free(int robot, const ArmShape& shape, int body);
  void link_points(const ArmShape& shape, int body, int link);
  void wake_near_robot(int robot);
  [[nodiscard]] bool robot_at_group(int robot, int group);
  void wake_touched();
  [[nodiscard]] bool touches_group(int body, int group);
  void find_pairs();
  void solids_on_each_other(int a, int b);
  void free_on_free(int a, int b);
  void free_on_fixed(int body);
  void note_pressed();
  void take(int fixed_shape);
  void touched_by_robot(int body, int robot);
  [[nodiscard]] const GripperPart& part(int robot, int index) const;
  [[nodiscard]] double friction(const Contact& contact) const;
  [[nodiscard]] bool may_touch_link(int robot, int other, int link) const;

  PhysicsModel& cell_;
  std::vector<Contact> found_;  // of the pair at hand
  std::vector<char> pressed_;   // bodies that a gripper touches, and trays under these
  std::vector<int> work_;       // solids to look at, in order
  std::vector<int> released_;   // in this step
  std::vector<Bounds> solid_bounds_;
  std::vector<int> order_;  // solids by their boxes' low x
  std::vector<std::pair<int, int>> pairs_;
  std::vector<Bounds> gripper_bounds_;
  std::vector<std::vector<char>> own_link_;  // robot, link: gripper may touch it
  ode::Geom box_, cylinder_;
};

}  // namespace aprsim::physics
