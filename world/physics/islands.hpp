#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "world/physics/physics_model.hpp"

namespace aprsim::physics {

/// How an island is solved: the phases of a step, in this order.
enum class Phase : std::uint8_t {
  kNone,       ///< dormant, moved by another body, or an idle gripper
  kCoupled,    ///< a gripper and what it presses on: ConstraintSystem, friction bounds follow the
               ///< normal forces
  kDecoupled,  ///< a gripper that touches nothing but what it holds: ConstraintSystem, the pistons
               ///< alone decide the normal forces
  kDirect,     ///< ODE's direct solver
  kIterative,  ///< ODE's projected Gauss-Seidel
};

/// Which bodies act on each other in a step, and how each such island is solved. Islands are the
/// connected components of the graph whose nodes are awake roots and grippers and whose edges are
/// contacts and virtual joints (union-find). A gripper's island is cut at the trays it touches:
/// what else lies on such a tray sees it as kinematic, and its reaction reaches the tray one step
/// later. No call allocates.
class Islands {
 public:
  explicit Islands(const PhysicsModel& model);

  /// Marks constraints as cut where needed. Merged bodies count as their root.
  void find(const PhysicsModel& model, std::span<ContactConstraint> constraints);

  [[nodiscard]] Phase phase_of_root(int body) const { return phase_of_node(body); }
  [[nodiscard]] Phase phase_of_gripper(int robot) const { return phase_of_node(free_ + robot); }
  /// Number of the island of a root or a gripper: that of one of its nodes.
  [[nodiscard]] int number_of_root(int body) const { return number_[index(body)]; }
  [[nodiscard]] int number_of_gripper(int robot) const { return number_[index(free_ + robot)]; }
  /// Of the island in which a contact is solved.
  [[nodiscard]] int number_of(const PhysicsModel& model, const ContactConstraint& constraint) const;
  /// Phase in which a contact is solved.
  [[nodiscard]] Phase phase_of(const PhysicsModel& model,
                               const ContactConstraint& constraint) const;
  /// True for roots solved together with a gripper.
  [[nodiscard]] bool with_gripper(int body) const { return near_[index(body)] != kFar; }
  /// Per root: number of its island (a root's index), -1 = with a gripper.
  [[nodiscard]] std::span<const int> island_of() const { return island_of_; }
  [[nodiscard]] bool any(Phase phase) const { return any_[static_cast<std::size_t>(phase)]; }
  /// Islands of grippers that are too large for the exact solver, in this step.
  [[nodiscard]] int oversized() const { return oversized_; }

 private:
  /// To a gripper: not connected, within its island, or a tray where that is cut.
  enum Nearness : std::uint8_t { kFar, kCore, kBorder };
  struct Sum {
    int rows = 0;
    bool gripper = false;  // one is in it
    bool foreign = false;  // contacts other than pads on gears
    bool pile = false;     // gears loose in a tray
  };

  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] Phase phase_of_node(int node) const { return phase_[index(node)]; }
  [[nodiscard]] int node(const PhysicsModel& model, BodyIndex body) const;
  [[nodiscard]] int root(int node);
  void unite(int a, int b);
  /// Calls f(node) for every awake root and every gripper.
  template <class F>
  void for_nodes(const PhysicsModel& model, const F& f) const {
    for (const int root : model.simplification.awake_roots()) f(root);
    for (int gripper = free_; gripper < count_; ++gripper) f(gripper);
  }
  void mark_near(const PhysicsModel& model, std::span<ContactConstraint> constraints);
  void choose_phases(const PhysicsModel& model);
  void sum_up(const PhysicsModel& model, std::span<const ContactConstraint> constraints);

  BodyIds ids_;
  int free_, count_;
  std::vector<Nearness> near_;
  std::vector<int> parent_, island_of_, number_;
  std::vector<Sum> sums_;
  std::vector<Phase> phase_;
  std::array<bool, 5> any_{};  // by phase
  int oversized_ = 0;
};

}  // namespace aprsim::physics
