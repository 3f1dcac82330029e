#include "world/cell/robot/collision_stop.hpp"

#include <cstdio>

#include "world/api/snapshot/contact_names.hpp"

namespace aprsim::world {
namespace {

/// A deflection of the mount beyond this is a collision of the gripper.
constexpr double kMaxPalmDeflection_m = 3e-3;

/// The largest contact force, those of the grip on a held body left out.
const physics::ArmForce* largest(std::span<const physics::ArmForce> forces, int held_body) {
  const auto grip = [held_body](const physics::ArmForce& force) {
    return force.on_gripper && !force.relayed && held_body >= 0 &&
           force.partner.kind == api::ContactSide::Kind::kBody && force.partner.index == held_body;
  };
  const physics::ArmForce* most = nullptr;
  for (const auto& force : forces) {
    if (grip(force)) continue;
    if (!most || force.f_W.squaredNorm() > most->f_W.squaredNorm()) most = &force;
  }
  return most;
}

/// Names the two partners of the largest contact.
std::string describe_contact(const robot::ArmModel& model, const api::CellDescription& cell,
                             std::span<const physics::ArmForce> forces, int held_body) {
  const physics::ArmForce* force = largest(forces, held_body);
  if (!force) return "";
  const auto& link = model.links[static_cast<std::size_t>(force->link)].name;
  char text[96];
  if (force->partner_link >= 0) {
    std::snprintf(text, sizeof text, " link %d with %.0f N", force->partner_link,
                  force->f_W.norm());
  } else {
    std::snprintf(text, sizeof text, " with %.0f N", force->f_W.norm());
  }
  return " (" + (force->on_gripper ? std::string("the gripper") : link) + " touches " +
         api::contact_name(cell, force->partner) + text + ")";
}

/// The limit that is exceeded; empty = none.
std::string overload(const robot::ServoArm& arm, const physics::GripperState& gripper,
                     bool has_tool) {
  if (!arm.trip_reason().empty()) return arm.trip_reason();
  if (!has_tool || gripper.palm_deflection_m <= kMaxPalmDeflection_m) return {};
  char text[96];
  std::snprintf(text, sizeof text, "gripper mount deflected by %.1f mm, limit %.1f mm",
                gripper.palm_deflection_m * 1e3, kMaxPalmDeflection_m * 1e3);
  return text;
}

}  // namespace

std::string collision_message(const robot::ServoArm& arm, const physics::GripperState& gripper,
                              bool has_tool, std::span<const physics::ArmForce> forces,
                              const api::CellDescription& cell) {
  const std::string limit = overload(arm, gripper, has_tool);
  if (limit.empty()) return {};
  return "Protective stop: " + limit +
         describe_contact(arm.model(), cell, forces, gripper.held_body) +
         "; the arm backs off by itself; send InitCanon, then move away";
}

}  // namespace aprsim::world
