#include <algorithm>

#include "world/physics/physics_world_impl.hpp"

// What the contacts of a step look like from outside.

namespace aprsim::physics {
namespace {

using Side = api::ContactSide;

template <typename Range>
int index_of(const Range& named, std::string_view name) {
  const auto found =
      std::find_if(named.begin(), named.end(), [&](const auto& one) { return one.name == name; });
  return found == named.end() ? -1 : static_cast<int>(found - named.begin());
}

Side side_of(const PhysicsModel& cell, BodyIndex node, int fixed) {
  if (node < 0) return {Side::Kind::kFixed, fixed};
  if (cell.nodes.is_free(node)) return {Side::Kind::kBody, node};
  return {Side::Kind::kRobot, cell.nodes.robot_of(node)};
}

/// What a link touches under the penalty law: another link or something fixed.
Side partner_of(const PhysicsModel& cell, const ArmForce& force) {
  if (force.with_link >= 0) return {Side::Kind::kRobot, index_of(cell.scene.robots, force.with)};
  return {Side::Kind::kFixed, index_of(cell.fixed.shapes, force.with)};
}

}  // namespace

void PhysicsWorld::write_contacts(std::vector<api::ContactSnapshot>& out) const {
  const PhysicsModel& cell = impl_->cell;
  out.clear();
  out.reserve(api::kMaxContacts);
  for (const ContactConstraint& touch : cell.touches) {
    if (out.size() == api::kMaxContacts) return;
    const Contact& contact = touch.contact;
    out.push_back({side_of(cell, contact.a, -1), side_of(cell, contact.b, touch.fixed), contact.p_W,
                   touch.f_W});
  }
  for (std::size_t r = 0; r < impl_->forces.size(); ++r) {
    const int robot = static_cast<int>(r);
    for (const ArmForce& force : impl_->forces[r]) {
      if (!force.by_law) continue;
      const Side partner = partner_of(cell, force);
      // Of a pair of arms, either has the contact in its list.
      if (partner.kind == Side::Kind::kRobot && partner.index < robot) continue;
      if (out.size() == api::kMaxContacts) return;
      out.push_back({{Side::Kind::kRobot, robot}, partner, force.p_W, force.f_W});
    }
  }
}

std::vector<std::string> PhysicsWorld::fixed_names() const {
  std::vector<std::string> names;
  for (const StaticShape& shape : impl_->cell.fixed.shapes) names.emplace_back(shape.name);
  return names;
}

}  // namespace aprsim::physics
