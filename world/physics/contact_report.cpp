#include "world/physics/contact_report.hpp"

namespace aprsim::physics {
namespace {

using Side = api::ContactSide;

constexpr std::size_t kForceCapacity = 256;  // of an arm

}  // namespace

ContactReport::ContactReport(const PhysicsModel& model)
    : model_(model), forces_(model.arms.size()) {
  for (auto& list : forces_) list.reserve(kForceCapacity);
}

void ContactReport::update(ArmPenalty& penalty) {
  for (auto& list : forces_) list.clear();
  for (const auto& constraint : model_.constraints) add_arm_forces(constraint);
  penalty.find(forces_);
}

/// Of each arm that has the contact: at the flange when it is with gripper or held part, or at the
/// link itself.
void ContactReport::add_arm_forces(const ContactConstraint& constraint) {
  const auto& contact = constraint.contact;
  for (std::size_t r = 0; r < forces_.size(); ++r) {
    const int robot = static_cast<int>(r);
    const bool a = in_hand(robot, contact.a), b = in_hand(robot, contact.b);
    const int flange = model_.arms[r].links() - 1;
    if (a && !b) {
      forces_[r].push_back({flange, contact.p_W, constraint.f_W, side(contact.b, constraint.fixed),
                            link(contact.b), true});
    } else if (b && !a) {
      forces_[r].push_back(
          {flange, contact.p_W, -constraint.f_W, side(contact.a, -1), link(contact.a), true});
    }
    if (model_.ids.is_link(contact.b) && model_.ids.robot_of(contact.b) == robot) {
      forces_[r].push_back({link(contact.b), contact.p_W, -constraint.f_W, side(contact.a, -1)});
    }
  }
}

/// Palm, fingers and what they hold: forces among these are the grip, not a load on the arm.
bool ContactReport::in_hand(int robot, BodyIndex id) const {
  if (id < 0) return false;
  if (model_.ids.is_gripper(id)) return model_.ids.robot_of(id) == robot;
  return model_.grippers[static_cast<std::size_t>(robot)].state().held_body == id;
}

int ContactReport::link(BodyIndex id) const {
  return model_.ids.is_link(id) ? model_.ids.link_of(id) : -1;
}

Side ContactReport::side(BodyIndex id, int fixed) const {
  if (id < 0) return {Side::Kind::kFixed, fixed};
  if (model_.ids.is_free(id)) return {Side::Kind::kBody, id};
  return {Side::Kind::kRobot, model_.ids.robot_of(id)};
}

void ContactReport::write(std::vector<api::ContactSnapshot>& out) const {
  out.clear();
  out.reserve(api::kMaxContacts);
  for (const ContactConstraint& constraint : model_.constraints) {
    if (out.size() == api::kMaxContacts) return;
    const Contact& contact = constraint.contact;
    out.push_back(
        {side(contact.a, -1), side(contact.b, constraint.fixed), contact.p_W, constraint.f_W});
  }
  for (std::size_t r = 0; r < forces_.size(); ++r) {
    const int robot = static_cast<int>(r);
    for (const ArmForce& force : forces_[r]) {
      if (!force.penalty) continue;
      // Of a pair of arms, either has the contact in its list.
      if (force.partner.kind == Side::Kind::kRobot && force.partner.index < robot) continue;
      if (out.size() == api::kMaxContacts) return;
      out.push_back({{Side::Kind::kRobot, robot}, force.partner, force.p_W, force.f_W});
    }
  }
}

}  // namespace aprsim::physics
