#include "world/scene/readers/light_curtain_reader.hpp"

#include "world/scene/checks/scene_solids.hpp"
#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {
namespace {

constexpr double kBeamRadius = 1e-6;  ///< of the solid that represents a beam

Solid solid_of_beam(const api::LightCurtainDescription& curtain, int beam) {
  const Eigen::Translation3d X_KS(curtain.range_m / 2, 0, beam * curtain.pitch_m);
  return {BoxSolid{{curtain.range_m / 2, kBeamRadius, kBeamRadius}},
          curtain.X_WK.isometry() * X_KS};
}

/// The name of a fixed body that a beam meets; empty if there is none.
std::string blocked_by(const Solid& beam, const Scene& scene) {
  for (const StaticBox& box : scene.fixed) {
    if (overlap_depth(beam, solid_of(box)) > 0) return box.name;
  }
  if (scene.conveyor && overlap_depth(beam, solid_of(*scene.conveyor)) > 0) return "the belt";
  if (scene.floor && depth_below_ground(beam) > 0) return "the floor";
  return "";
}

}  // namespace

void read_light_curtain(const yaml::Node& node, Scene& scene) {
  if (!node) return;
  const yaml::Map keys = node.map({"xyz_m", "rpy_deg", "beams", "pitch_m", "range_m", "reaction"});
  api::LightCurtainDescription curtain;
  curtain.X_WK = read_pose(keys["xyz_m"], keys["rpy_deg"]);
  curtain.beams = static_cast<int>(keys["beams"].integer(1, api::kMaxCurtainBeams));
  curtain.pitch_m = keys["pitch_m"].number({.min = 0, .max = 1, .open_min = true});
  curtain.range_m = keys["range_m"].number({.min = 0, .max = 100, .open_min = true});
  constexpr api::CurtainReaction kReactions[] = {
      api::CurtainReaction::kNone, api::CurtainReaction::kBeltStop,
      api::CurtainReaction::kProtectiveStop, api::CurtainReaction::kAll};
  curtain.reaction =
      kReactions[keys["reaction"].word_or(0, {"none", "belt_stop", "protective_stop", "all"})];
  for (int beam = 0; beam < curtain.beams; ++beam) {
    const std::string obstacle = blocked_by(solid_of_beam(curtain, beam), scene);
    if (obstacle.empty()) continue;
    keys["xyz_m"].error("beam " + std::to_string(beam + 1) + " blocked by " + obstacle,
                        "beams clear of everything fixed");
    break;
  }
  scene.light_curtain = curtain;
}

}  // namespace aprsim::scene
