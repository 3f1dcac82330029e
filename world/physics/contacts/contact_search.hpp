#pragma once

#include <span>
#include <vector>

#include "world/physics/contacts/body_collider.hpp"
#include "world/physics/contacts/wake_search.hpp"

namespace aprsim::physics {

/// Finds the contacts of a step: broad phase by sweep and prune over tight axis-aligned boxes, the
/// narrow phase is BodyCollider's. Sleeping groups are only tested where a moving body is in their
/// box. A touch wakes them and unmerges bodies in the same step, and so does a fault next to them
/// (WakeSearch). No call allocates after warm-up. The order is fixed by body numbers.
class ContactSearch {
 public:
  explicit ContactSearch(PhysicsModel& model);

  /// Fills model.constraints. `searched`, if given, is by body: a pair without a marked body is
  /// skipped, unless one of the two is pressed.
  void find(std::span<const char> searched = {});
  /// Unmerges bodies from their parents and adds their contacts with these.
  void unmerge(std::span<const int> members);
  /// Cached manifolds of the last step.
  [[nodiscard]] ContactCache& cache() { return collider_.cache(); }
  [[nodiscard]] const ContactCache& cache() const { return collider_.cache(); }

 private:
  void search();
  void find_for_robot(int robot);
  void gripper_on_free(int robot, int part, int body);
  void gripper_on_fixed(int robot, int part);
  void gripper_on_robots(int robot, int part);
  void link_on_free(int robot, const ArmShape& shape, int body);
  void find_pairs();
  void sort_boxes();
  void add_pair(int a, int b);
  void composites_on_each_other(int a, int b);
  void free_on_fixed(int body);
  void add_found(int fixed_shape);
  /// See ContactConstraint.
  using Surfaces = MaterialTable::Surfaces;
  [[nodiscard]] static double of_pair(const scene::SurfacePairs& property, SurfacePair pair);
  /// `fixed`: number of the fixed shape, -1 = none.
  [[nodiscard]] Surfaces surfaces_of(const Contact& contact, int fixed) const;
  [[nodiscard]] int material_of(BodyIndex id, int ground) const;
  [[nodiscard]] bool is_searched(int body) const;
  [[nodiscard]] bool may_touch_link(int robot, int other, int link) const;
  [[nodiscard]] GripperMechanism& gripper(int robot) {
    return model_.grippers[static_cast<std::size_t>(robot)];
  }

  PhysicsModel& model_;
  BodyCollider collider_;
  WakeSearch wake_search_;
  std::span<const char> searched_;  // by body; empty = all
  std::vector<Contact> found_;      // of the present pair
  std::vector<int> unmerged_;       // in this step
  struct Box {
    Aabb bounds;
    int root = -1;
  };
  std::vector<Box> boxes_;         // about composites, by their low x
  std::vector<int> sorted_roots_;  // those of the boxes, ascending
  /// A body that may touch another one.
  struct Partner {
    int body = -1;
    int next = -1;  // of the same body's
  };
  std::vector<Partner> pairs_;
  std::vector<int> first_pair_;              // by root
  std::vector<std::vector<char>> own_link_;  // robot, link: gripper may touch it
};

}  // namespace aprsim::physics
