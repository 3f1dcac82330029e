#pragma once

#include <vector>

#include "world/physics/contacts/arm_force.hpp"
#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

/// Contact of arm links with fixed things, with other arms and with each other. To the solver links
/// are kinematic and take no force, so these follow the penalty law of
/// world/robot/servo/contact_law.hpp (spring, damper and regularised Coulomb friction). Shapes that
/// overlap at the start are exempt for good: neighbouring links, a base in its pedestal.
class ArmPenalty {
 public:
  explicit ArmPenalty(PhysicsModel& model);

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

  PhysicsModel& model_;
  std::vector<OdeGeom> fixed_geoms_;
  std::vector<std::vector<char>> exempt_fixed_;  // robot; shape x fixed
  std::vector<LinkPair> exempt_links_;
  std::vector<Contact> found_;
};

}  // namespace aprsim::physics
