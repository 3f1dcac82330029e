#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "world/physics/cell.hpp"

namespace aprsim::physics {

/// How an island is solved.
enum class Phase : std::uint8_t {
  kNone,       ///< dormant, moved by another body, or a gripper that follows its flange
  kPress,      ///< with a gripper and what it touches: friction bounds from normal forces with
               ///< friction, then one exact solve
  kHold,       ///< with a gripper that touches nothing but what it holds: the piston decides the
               ///< normal forces, whatever friction does
  kDirect,     ///< ODE's direct solver
  kIterative,  ///< projected Gauss-Seidel
};

/// Which bodies act on each other in a step, and how each such island is solved. A gripper's island
/// is cut at the trays it touches: what else lies on such a tray sees it as moved from outside, and
/// its reaction reaches the tray one step later. No call allocates.
class Islands {
 public:
  explicit Islands(const Cell& cell);

  /// Marks `touches` as cut where needed. Merged bodies count as their root.
  void find(const Cell& cell, std::span<Touch> touches);

  [[nodiscard]] Phase phase_of_solid(int body) const { return phase_of_node(body); }
  [[nodiscard]] Phase phase_of_gripper(int robot) const { return phase_of_node(free_ + robot); }
  /// Number of the island of a solid or a gripper: that of one of its nodes.
  [[nodiscard]] int number_of_solid(int body) const { return number_[index(body)]; }
  [[nodiscard]] int number_of_gripper(int robot) const { return number_[index(free_ + robot)]; }
  /// Of the island in which a touch is solved.
  [[nodiscard]] int number_of(const Cell& cell, const Touch& touch) const;
  /// Phase in which a touch is solved.
  [[nodiscard]] Phase phase_of(const Cell& cell, const Touch& touch) const;
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
  [[nodiscard]] int node(const Cell& cell, BodyIndex body) const;
  [[nodiscard]] int root(int node);
  void unite(int a, int b);
  /// Calls f(node) for every solid and every gripper.
  template <class F>
  void for_nodes(const Cell& cell, const F& f) const {
    for (const int solid : cell.simplification.solids()) f(solid);
    for (int gripper = free_; gripper < count_; ++gripper) f(gripper);
  }
  void mark_near(const Cell& cell, std::span<Touch> touches);
  void choose_phases(const Cell& cell);
  void sum_up(const Cell& cell, std::span<const Touch> touches);

  NodeNumbers nodes_;
  int free_, count_;
  std::vector<Nearness> near_;
  std::vector<int> parent_, island_of_, number_;
  std::vector<Sum> sums_;
  std::vector<Phase> phase_;
  std::array<bool, 5> any_{};  // by phase
};

}  // namespace aprsim::physics
