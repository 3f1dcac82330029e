#pragma once

#include <span>
#include <vector>

#include "world/physics/contacts/body_collider.hpp"
#include "world/physics/contacts/wake_search.hpp"

namespace aprsim::physics {

/// Finds the contacts of a step: broad phase by sweep and prune over tight axis-aligned boxes, the
/// narrow phase is BodyCollider's. Sleeping groups are only looked at where something that moves is
/// in their box; whatever touches them wakes them, and frees merged bodies, in the same step, and
/// so does a fault next to them (WakeSearch). No call allocates after warm-up. The order is fixed
/// by body numbers.
class ContactSearch {
 public:
  explicit ContactSearch(PhysicsModel& model);

  /// Fills model.constraints. By body, if it is given: 0 for one that is looked at only where it
  /// meets one that is not, or is pressed.
  void find(std::span<const char> looked_at = {});
  /// Releases merged bodies from their parents and adds their contacts with these.
  void release(std::span<const int> members);
  /// From one step to the next.
  [[nodiscard]] KeptContacts& kept() { return collider_.kept(); }
  [[nodiscard]] const KeptContacts& kept() const { return collider_.kept(); }

 private:
  void search();
  void find_for_robot(int robot);
  void gripper_on_free(int robot, int part, int body);
  void gripper_on_fixed(int robot, int part);
  void gripper_on_robots(int robot, int part);
  void link_on_free(int robot, const ArmShape& shape, int body);
  void find_pairs();
  void sort_boxes();
  void note_pair(int a, int b);
  void composites_on_each_other(int a, int b);
  void free_on_fixed(int body);
  void add_found(int fixed_shape);
  /// See ContactConstraint.
  struct Surfaces {
    double friction = 0, restitution = 0, rolling_m = 0, spinning_m = 0;
  };
  [[nodiscard]] static double of_pair(const scene::SurfacePairs& property, SurfacePair pair);
  [[nodiscard]] Surfaces surfaces_of(const Contact& contact) const;
  [[nodiscard]] bool is_looked_at(int body) const;
  [[nodiscard]] bool may_touch_link(int robot, int other, int link) const;
  [[nodiscard]] GripperMechanism& gripper(int robot) {
    return model_.grippers[static_cast<std::size_t>(robot)];
  }

  PhysicsModel& model_;
  BodyCollider collider_;
  WakeSearch wake_search_;
  std::span<const char> looked_at_;  // by body; empty = all are
  std::vector<Contact> found_;       // of the pair at hand
  std::vector<int> released_;        // in this step
  struct Box {
    Aabb bounds;
    int root = -1;
  };
  std::vector<Box> boxes_;         // about composites, by their low x
  std::vector<int> sorted_roots_;  // those of the boxes, ascending
  /// What may meet a body.
  struct Partner {
    int body = -1;
    int next = -1;  // of the same body's
  };
  std::vector<Partner> pairs_;
  std::vector<int> first_pair_;              // by root
  std::vector<std::vector<char>> own_link_;  // robot, link: gripper may touch it
};

}  // namespace aprsim::physics
