#pragma once

#include <span>
#include <vector>

#include "world/physics/arm_force.hpp"
#include "world/physics/arm_penalty.hpp"
#include "world/physics/physics_model.hpp"

namespace aprsim::physics {

/// What the contacts of a step look like from outside: the forces on the arms, and the list of all
/// contacts.
class ContactReport {
 public:
  explicit ContactReport(const PhysicsModel& model);

  /// After a step: from the solved constraints, and by the penalty law at the present poses.
  void update(ArmPenalty& penalty);
  /// Forces on links, palm, fingers and held part from outside (the grip itself left out).
  [[nodiscard]] std::span<const ArmForce> arm_forces(int robot) const {
    return forces_[static_cast<std::size_t>(robot)];
  }
  /// Replaces `out` by the contacts, at most api::kMaxContacts.
  void write(std::vector<api::ContactSnapshot>& out) const;

  using State = std::vector<std::vector<ArmForce>>;  ///< by robot
  [[nodiscard]] const State& save() const { return forces_; }
  void restore(const State& state) { forces_ = state; }

 private:
  void add_arm_forces(const ContactConstraint& constraint);
  [[nodiscard]] bool in_hand(int robot, BodyIndex id) const;
  [[nodiscard]] api::ContactSide side(BodyIndex id, int fixed) const;
  [[nodiscard]] int link(BodyIndex id) const;

  const PhysicsModel& model_;
  State forces_;
};

}  // namespace aprsim::physics
