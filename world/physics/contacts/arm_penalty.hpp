#pragma once

#include <cstddef>
#include <cstdint>
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
  struct ShapePair {
    int a, b;
  };
  /// Two arms, or one with itself.
  struct ArmPair {
    int a, b;
    std::vector<ShapePair> shapes{};  ///< that may touch
    /// Placements at which none of them did, of both arms; 0 = not known.
    std::uint64_t apart_a = 0, apart_b = 0;
  };
  struct FixedPair {
    int shape;
    std::size_t fixed;
  };
  /// An arm and the fixed things.
  struct ArmOnFixed {
    std::vector<FixedPair> shapes{};  ///< that may touch
    std::uint64_t apart = 0;          ///< as in ArmPair
  };
  void on_fixed(int robot, std::vector<std::vector<ArmForce>>& forces);
  /// Contacts of a link with a fixed shape into found_, normals into the link.
  void on_fixed_shape(const ArmShape& link, std::size_t f);
  void on_other(ArmPair& arms, std::vector<std::vector<ArmForce>>& forces);
  [[nodiscard]] bool may_meet(int robot_a, int shape_a, int robot_b, int shape_b) const;
  [[nodiscard]] bool overlap(const OdeGeom& a, const OdeGeom& b);
  [[nodiscard]] const ArmShape& shape(int robot, int index) const;

  PhysicsModel& model_;
  std::vector<OdeGeom> fixed_geoms_;
  std::vector<ArmOnFixed> on_fixed_;  // by robot
  std::vector<ArmPair> pairs_;
  std::vector<Contact> found_;
};

}  // namespace aprsim::physics
