#include "world/scenario/plan.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <string_view>
#include <utility>

#include "world/scenario/scene_change.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::scenario {
namespace {

using yaml::detail::list;
using yaml::detail::scalar;

constexpr int kMaxDraws = 100;
constexpr double kDegree = 0.017453292519943295;

/// Random numbers by name: FNV-1a hash of the name and the seed, mixed by SplitMix64.
class Draw {
 public:
  Draw(std::uint64_t seed, int trial)
      : start_(seed * 0x9e3779b97f4a7c15U + static_cast<std::uint64_t>(trial)) {}

  /// A uniform number, recorded as name + `unit` in multiples of `per_unit`.
  [[nodiscard]] double between(std::string_view name, double min, double max, std::string_view unit,
                               double per_unit = 1) {
    const double value = uniform(name, min, max);
    if (min != max) drawn_[std::string(name).append(unit)] = value / per_unit;
    return value;
  }
  [[nodiscard]] double around_zero(const std::string& name, double bound, std::string_view unit,
                                   double per_unit = 1) {
    return bound == 0 ? 0 : between(name, -bound, bound, unit, per_unit);
  }
  [[nodiscard]] std::map<std::string, double> take_drawn() { return std::move(drawn_); }

 private:
  [[nodiscard]] double uniform(std::string_view name, double min, double max) const {
    std::uint64_t hash = 0xcbf29ce484222325U ^ start_;
    for (const char c : name) {
      hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
    }
    std::uint64_t z = hash + 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    z ^= z >> 31U;
    return min + (max - min) * (static_cast<double>(z >> 11U) * 0x1p-53);
  }

  std::uint64_t start_;
  std::map<std::string, double> drawn_;
};

void vary_tray(Tree& tray, const Variation& variation, Draw& draw) {
  const std::string name = child(tray, "name").scalar;
  // A tray without a support has a deliberate pose in space.
  if (tray.find("on") != nullptr) {
    Tree& xy = child(tray, "xy_m");
    const double x = std::stod(xy.items[0].scalar), y = std::stod(xy.items[1].scalar);
    xy = list({x + draw.around_zero(name + ".x", variation.tray_xy_m, "_m"),
               y + draw.around_zero(name + ".y", variation.tray_xy_m, "_m")});
    if (variation.tray_yaw_rad > 0) {
      Tree& yaw = child(tray, "yaw_deg");
      const double yaw_deg = yaw.scalar.empty() ? 0 : std::stod(yaw.scalar);
      const double turn_deg =
          draw.around_zero(name + ".yaw", variation.tray_yaw_rad, "_deg", kDegree) / kDegree;
      yaw = scalar(std::clamp(yaw_deg + turn_deg, -360.0, 360.0));
    }
  }
  yaml::detail::Entry* gears = tray.find("gears");
  if (gears == nullptr || variation.gear_yaw_rad == 0) return;
  for (auto& gear : gears->value.entries) {
    if (gear.value.kind == Tree::Kind::kMap) continue;
    Tree turned{.kind = Tree::Kind::kMap};
    child(turned, "name") = gear.value;
    child(turned, "yaw_deg") = scalar(
        draw.around_zero(gear.value.scalar + ".yaw", variation.gear_yaw_rad, "_deg", kDegree) /
        kDegree);
    gear.value = std::move(turned);
  }
}

void vary_physics(Tree& scene, const scene::Scene& before, const Variation& variation, Draw& draw) {
  if (variation.friction > 0) {
    const double factor = 1 + draw.around_zero("friction", variation.friction, "_share");
    Tree& friction = child(child(scene, "physics"), "friction");
    const scene::SurfacePairs& was = before.physics.friction;
    child(friction, "gear_tray") = scalar(was.gear_tray * factor);
    child(friction, "gear_gear") = scalar(was.gear_gear * factor);
    child(friction, "gear_ground") = scalar(was.gear_ground * factor);
    child(friction, "tray_belt") = scalar(was.tray_belt * factor);
    child(friction, "tray_ground") = scalar(was.tray_ground * factor);
    child(friction, "tray_tray") = scalar(was.tray_tray * factor);
    child(friction, "robot") = scalar(was.robot * factor);
  }
  if (variation.gear_mass == 0) return;
  for (const auto& [name, type] : before.gear_types) {
    const double factor = 1 + draw.around_zero(name + ".mass", variation.gear_mass, "_share");
    child(child(child(scene, "gear_types"), name), "mass_kg") = scalar(type.mass_kg * factor);
  }
}

void vary_vision(Tree& scene, const Variation& variation, Draw& draw) {
  yaml::detail::Entry* robots = scene.find("robots");
  if (robots == nullptr) return;
  for (Tree& robot : robots->value.items) {
    const std::string name = child(robot, "name").scalar;
    if (const auto& noise = variation.vision_position_noise_m) {
      child(child(robot, "vision"), "position_noise_m") =
          scalar(draw.between(name + ".position_noise", (*noise)[0], (*noise)[1], "_m"));
    }
    if (const auto& noise = variation.vision_rotation_noise_rad) {
      child(child(robot, "vision"), "rotation_noise_deg") =
          scalar(draw.between(name + ".rotation_noise", (*noise)[0], (*noise)[1], "_deg", kDegree) /
                 kDegree);
    }
  }
}

Result<Plan> draw_plan(const Scenario& scenario, std::uint64_t seed, int trial,
                       const scene::DataPaths& paths) {
  auto tree = yaml::detail::parse(scenario.scene_text, scenario.scene_file);
  if (!tree) return tl::unexpected(std::move(tree.error()));
  Draw draw(seed, trial);
  child(*tree, "seed") = {.kind = Tree::Kind::kScalar,
                          .scalar = std::to_string(seed & 0x7fffffffffffffffU)};
  for_each_tray(*tree, [&](Tree& tray) { vary_tray(tray, scenario.variation, draw); });
  vary_physics(*tree, scenario.scene, scenario.variation, draw);
  vary_vision(*tree, scenario.variation, draw);
  Plan out{.seed = seed, .scene_text = yaml::detail::write(*tree)};
  auto scene = scene::read_scene(out.scene_text, scenario.scene_file, paths);
  if (!scene) return tl::unexpected(std::move(scene.error()));
  out.scene = std::move(*scene);
  out.faults = scenario.faults;
  for (std::size_t i = 0; i < out.faults.size(); ++i) {
    auto& at_s = out.faults[i].at_s;
    if (!at_s) continue;
    const double time_s = draw.between("fault." + std::to_string(i), (*at_s)[0], (*at_s)[1], "_s");
    at_s = {time_s, time_s};
  }
  for (std::size_t i = 0; i < scenario.kills_s.size(); ++i) {
    const auto& [from_s, to_s] = scenario.kills_s[i];
    out.kills_s.push_back(draw.between("kill." + std::to_string(i), from_s, to_s, "_s"));
  }
  std::ranges::sort(out.kills_s);
  out.drawn = draw.take_drawn();
  return out;
}

}  // namespace

Result<Plan> plan(const Scenario& scenario, std::uint64_t seed, const scene::DataPaths& paths) {
  auto drawn = draw_plan(scenario, seed, 0, paths);
  for (int trial = 1; trial < kMaxDraws && !drawn; ++trial) {
    drawn = draw_plan(scenario, seed, trial, paths);
  }
  if (drawn) return drawn;
  return fail(ErrorCode::kInvalidArgument, "vary",
              scenario.file + ": vary: found no valid scene in " + std::to_string(kMaxDraws) +
                  " draws, expected less variation (the last: " + drawn.error().message + ")");
}

}  // namespace aprsim::scenario
