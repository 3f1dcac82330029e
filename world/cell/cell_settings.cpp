#include "world/cell/cell_settings.hpp"

#include <algorithm>
#include <cmath>

#include "world/scene/model/tool.hpp"

namespace aprsim::world {

using api::CurtainReaction;

std::optional<int> CellSettings::find_body(std::string_view name) const {
  const auto found = std::ranges::find(bodies, name, &scene::FreeBody::name);
  if (found == bodies.end()) return std::nullopt;
  return static_cast<int>(found - bodies.begin());
}

bool CellSettings::curtain_stops_belt() const {
  return light_curtain && (light_curtain->reaction == CurtainReaction::kBeltStop ||
                           light_curtain->reaction == CurtainReaction::kAll);
}

bool CellSettings::curtain_stops_robots() const {
  return light_curtain && (light_curtain->reaction == CurtainReaction::kProtectiveStop ||
                           light_curtain->reaction == CurtainReaction::kAll);
}

CellSettings settings_of(const scene::Scene& scene, std::span<const robot::ArmModel> models) {
  CellSettings out;
  out.step_s = scene.physics.step_s;
  out.step_size = SimTime(std::llround(scene.physics.step_s * 1e9));
  out.bodies = scene::free_bodies_of(scene);
  out.tool_count = scene::tools_of(scene).size();
  for (const robot::ArmModel& model : models) {
    auto& names = out.joint_names.emplace_back();
    for (const auto& joint : model.joints) names.push_back(joint.name);
  }
  out.conveyor = scene.conveyor;
  out.light_curtain = scene.light_curtain;
  return out;
}

}  // namespace aprsim::world
