#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/scene.hpp"
#include "world/scene/readers/type_reader.hpp"

namespace aprsim::scene {

/// Where each free body stands in the file, for messages; same order as in the scene.
struct BodyNodes {
  std::vector<yaml::Node> trays, gears, parts;
};

inline constexpr std::array<std::string_view, 14> kPhysicsKeys = {"step_s",
                                                                  "gravity_m_s2",
                                                                  "friction",
                                                                  "restitution",
                                                                  "rolling_resistance_mm",
                                                                  "spinning_resistance_mm",
                                                                  "materials",
                                                                  "residual_m_s",
                                                                  "simplification",
                                                                  "simplify_speed_m_s",
                                                                  "simplify_accel_m_s2",
                                                                  "simplify_force_n",
                                                                  "engine",
                                                                  "ode"};
[[nodiscard]] Physics read_physics(const yaml::Node& node);

/// Reads tools, robots, cameras, conveyor, fixed, fixtures, holders, floor, light curtain, trays,
/// gears and parts into `scene`; types come from `types`.
[[nodiscard]] BodyNodes read_objects(const yaml::Map& keys, const Types& types, Scene& scene);

}  // namespace aprsim::scene
