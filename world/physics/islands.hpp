#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "world/physics/physics_model.hpp"

namespace aprsim::physics {

/// How an island is solved.
enum class Phase : std::uint8_t {
  kNone,       ///< dormant, moved by another body, or a gripper that follows its flange
  kCoupled,    ///< with a gripper and what it touches: friction bounds from normal forces with
               ///< friction, then one exact solve
  kDecoupled,  ///< with a gripper that touches nothing but what it holds: the piston decides the
               ///< normal forces, whatever friction does
  kDirect,     ///< ODE's direct solver
  kIterative,  ///< projected Gauss-Seidel
};

/// Which bodies act on each other in a step, and how each such island is solved. A gripper's island
/// is cut at the trays it touches: what else lies on such a tray sees it as moved from outside, and
/// its reaction reaches the tray one step later. No call allocates.
class Islands {
 public:
  explicit Islands(const PhysicsModel& cell);

  /// Marks `touches` as cut where needed. Merged bodies count as their root.
  void find(const PhysicsModel& cell, std::span<ContactConstraint> touches);

  [[nodiscard]] Phase phase_of_solid(int body) const { return phase_of_node(body); }
  [[nodiscard]] Phase phase_of_gripper(int robot) const { return phase_of_node(free_ + robot); }
  /// Number of the island of a solid or a gripper: that of one of its nodes.
  [[nodiscard]] int number_of_solid(int body) const { return number_[index(body)]; }
  [[nodiscard]] int number_of_gripper(int robot) const { return number_[index(free_ + robot)]; }
  /// Of the island in which a touch is solved.
  [[nodiscard]] int number_of(const PhysicsModel& cell, const ContactConstraint& touch) const;
  /// Phase in which a touch is solved.
  [[nodiscard]] Phase phase_of(const PhysicsModel& cell, const ContactConstraint& touch) const;
  /// True for solids solved together with a gripper.
  [[nodiscard]] bool with_gripper(int body) const { return near_[index(body)] != kFar; }
  /// Per solid: number of its island (a solid's index), -1 = with a gripper.
  [[nodiscard]] std::span<const int> island_of() const { return island_of_; }
  [[nodiscard]] bool any(Phase phase) const { return any_[static_cast<std::size_t>(phase)]; }

 private:
  enum Nearness : std::uint8_t { kFar, kCore, kBorder };
  struct Sum {
    int rows = 0;
    bool gripper = false, foreign = false, pile = false, active = false;
  };

  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] Phase phase_of_node(int node) const { return phase_[index(node)]; }
  [[nodiscard]] int node(const PhysicsModel& cell, BodyIndex body) const;
  [[nodiscard]] int root(int node);
  void unite(int a, int b);
  /// Calls f(node) for every solid and every gripper.
  template <class F>
  void for_nodes(const PhysicsModel& cell, const F& f) const {
    for (const int solid : cell.simplification.solids()) f(solid);
    for (int gripper = free_; gripper < count_; ++gripper) f(gripper);
  }
  void mark_near(const PhysicsModel& cell, std::span<ContactConstraint> touches);
  void choose_phases(const PhysicsModel& cell);
  void sum_up(const PhysicsModel& cell, std::span<const ContactConstraint> touches);

  BodyIds nodes_;
  int free_, count_;
  std::vector<Nearness> near_;
  std::vector<int> parent_, island_of_, number_;
  std::vector<Sum> sums_;
  std::vector<Phase> phase_;
  std::array<bool, 5> any_{};  // by phase
};

}  // namespace aprsim::physics
