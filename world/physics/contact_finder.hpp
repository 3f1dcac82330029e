#pragma once

#include <vector>

#include "world/physics/cell.hpp"

namespace aprsim::physics {

/// Finds the contacts of a step: broadphase over tight axis-aligned boxes, exact geometry from
/// contact_generation.hpp, links by ODE's primitives. Bodies that rest (Simplification) are only
/// tested against what moves; whatever touches them wakes them in the same step. No call
/// allocates after warm-up. The order is fixed by body numbers.
class ContactFinder {
 public:
  explicit ContactFinder(Cell& cell);

  /// Fills cell.touches.
  void find();

 private:
  void find_for_robot(int robot);
  void gripper_on_free(int robot, int part, int body);
  void gripper_on_fixed(int robot, int part);
  void gripper_on_robots(int robot, int part);
  void link_on_free(int robot, const ArmShape& shape, int body);
  void find_for_free(int body);
  void probe(int body);
  void free_on_free(int a, int b);
  void free_on_fixed(int body, bool skip_belt);
  void take(int fixed_shape);
  void wake(int body);
  void touched_by_robot(int body, int robot);
  [[nodiscard]] const GripperPart& part(int robot, int index) const;
  [[nodiscard]] double friction(const Contact& contact) const;
  [[nodiscard]] bool may_touch_link(int robot, int other, int link) const;

  Cell& cell_;
  std::vector<Contact> found_;  // of the pair at hand
  std::vector<int> work_;       // bodies to look at, in order
  std::vector<char> done_;
  std::vector<Bounds> gripper_bounds_;
  std::vector<std::vector<char>> own_link_;  // robot, link: gripper may touch it
  ode::Geom box_, cylinder_;
};

}  // namespace aprsim::physics
