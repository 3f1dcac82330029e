#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

/// Islands of bodies that act on each other in a step: the connected components of a graph
/// (union-find). Its nodes are awake roots and grippers that are not idle, its edges contacts and
/// virtual joints. Kinematic things (belt, table, arms) connect nothing. No call allocates.
class Islands {
 public:
  explicit Islands(const PhysicsModel& model);

  /// Merged bodies count as their root.
  void find(const PhysicsModel& model, std::span<const ContactConstraint> constraints);

  /// Number of the island of a root or a gripper: its lowest node.
  [[nodiscard]] int number_of_root(int body) const { return number_[index(body)]; }
  [[nodiscard]] int number_of_gripper(int robot) const { return number_[index(free_ + robot)]; }
  /// Number of the island in which a contact is solved.
  [[nodiscard]] int number_of(const PhysicsModel& model, const ContactConstraint& constraint) const;
  /// Number of the touching bodies that a root belongs to, for the detection of rest; -1 =
  /// with a gripper. A tray that a gripper touches is with it, the parts on the tray are not.
  [[nodiscard]] std::span<const int> resting_together() const { return together_; }

 private:
  /// To a gripper: not connected, connected, or a tray where the search ends.
  enum Nearness : std::uint8_t { kFar, kCore, kBorder };

  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] int node(const PhysicsModel& model, BodyIndex body) const;
  [[nodiscard]] int root(int node);
  void unite(int a, int b);
  /// Calls f(node) for every awake root and every gripper.
  template <class F>
  void for_nodes(const PhysicsModel& model, const F& f) const {
    for (const int root : model.simplification.awake_roots()) f(root);
    for (int gripper = free_; gripper < count_; ++gripper) f(gripper);
  }
  /// Calls f(node, node) for all contacts of two nodes, and for every virtual joint between them.
  template <class F>
  void for_edges(const PhysicsModel& model, std::span<const ContactConstraint> constraints,
                 const F& f) const {
    BodyIndex last_a = kGround, last_b = kGround;
    for (const auto& constraint : constraints) {
      const Contact& contact = constraint.contact;
      // Contacts of the same two bodies mostly follow each other.
      if (contact.a == last_a && contact.b == last_b) continue;
      last_a = contact.a;
      last_b = contact.b;
      const int a = node(model, contact.a), b = node(model, contact.b);
      if (a >= 0 && b >= 0) f(a, b);
    }
    for (const auto& pair : model.simplification.joined_pairs()) f(pair.a, pair.b);
  }
  void mark_near(const PhysicsModel& model, std::span<const ContactConstraint> constraints);

  BodyIds ids_;
  int free_, count_;
  std::vector<Nearness> near_;
  std::vector<int> parent_, together_, number_;
};

}  // namespace aprsim::physics
