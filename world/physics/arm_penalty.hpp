#pragma once

#include <vector>

#include "world/physics/physics_model.hpp"

namespace aprsim::physics {

/// Contact of arm links with fixed things, with other arms and with themselves. ODE computes no
/// force between bodies that are both moved from outside, so these follow the law of
/// world/robot/contact_law.hpp.
class ArmPenalty {
 public:
  explicit ArmPenalty(PhysicsModel& cell);

  /// Appends the forces at the present poses to `forces` (per robot).
  void find(std::vector<std::vector<ArmForce>>& forces);

 private:
  struct LinkPair {
    int robot_a, shape_a, robot_b, shape_b;
    bool operator==(const LinkPair&) const = default;
  };
  void on_fixed(int robot, std::vector<std::vector<ArmForce>>& forces);
  void on_other(int robot_a, int robot_b, std::vector<std::vector<ArmForce>>& forces);
  [[nodiscard]] bool may_touch(int robot_a, int shape_a, int robot_b, int shape_b) const;
  [[nodiscard]] const ArmShape& shape(int robot, int index) const;

  PhysicsModel& cell_;
  std::vector<ode::Geom> fixed_geoms_;
  std::vector<std::vector<char>> exempt_fixed_;  // robot; shape x fixed
  std::vector<LinkPair> exempt_links_;
  std::vector<Contact> found_;
};

}  // namespace aprsim::physics
