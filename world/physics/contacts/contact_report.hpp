#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "world/physics/contacts/arm_force.hpp"
#include "world/physics/contacts/arm_penalty.hpp"
#include "world/physics/contacts/contact_pair.hpp"
#include "world/physics/model/physics_model.hpp"

namespace aprsim::physics {

/// Contacts of a step for observers: the forces on the arms, and the list of all contacts.
class ContactReport {
 public:
  explicit ContactReport(const PhysicsModel& model);

  void begin_step();
  /// After a substep that is `share` of the step: adds its solved constraints. Forces are means
  /// over the step.
  void add_substep(double share);
  /// Adds the arms' forces by the penalty law at the present poses.
  void end_step(ArmPenalty& penalty);
  /// Forces on links, palm and fingers. Weight, inertia and contacts of a held body act through the
  /// pads.
  [[nodiscard]] std::span<const ArmForce> arm_forces(int robot) const {
    return forces_[static_cast<std::size_t>(robot)];
  }
  /// Replaces `out` by the contacts in the order of their sides, robots first, at most
  /// api::kMaxContacts: those of the last step, and those that contact simplification has frozen.
  void write(std::vector<api::ContactSnapshot>& out);
  /// All pairs of the same list; the next write() reuses it.
  [[nodiscard]] const ContactPairs& pairs();

  using State = std::vector<std::vector<ArmForce>>;  ///< by robot
  [[nodiscard]] const State& save() const { return forces_; }
  void restore(const State& state);

 private:
  /// Arguments of which the list of frozen contacts is a function.
  struct FrozenKey {
    std::uint64_t merged = 0, asleep = 0;
    double belt_travel_m = 0;
    bool operator==(const FrozenKey&) const = default;
  };
  void add_arm_forces(const ContactConstraint& constraint, double share);
  void add_suction(std::size_t robot, double share);
  [[nodiscard]] bool of_gripper(int robot, BodyIndex id) const;
  [[nodiscard]] api::ContactSide side(BodyIndex id, int fixed) const;
  [[nodiscard]] int link(BodyIndex id) const;
  void refresh_frozen();
  void add_frozen(const FrozenContacts& frozen);
  void gather();
  void sort();
  void refresh();

  const PhysicsModel& model_;
  State forces_;
  std::vector<api::ContactSnapshot> frozen_;  // in the world
  FrozenKey frozen_key_;
  bool frozen_known_ = false;
  bool fresh_ = false;                     // the list is that of the last step, by pairs()
  std::vector<api::ContactSnapshot> all_;  // the present list
  ContactPairs pairs_;
  bool pairs_known_ = false;
  std::vector<std::uint64_t> keys_, last_keys_, order_;
};

}  // namespace aprsim::physics
