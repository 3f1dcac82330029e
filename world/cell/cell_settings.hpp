#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "world/api/values/light_curtain.hpp"
#include "world/base/time.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/scene/model/free_body.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

/// The values of a scene that decide how a cell behaves, besides those that robots and physics read
/// themselves. Constant while a world lives.
struct CellSettings {
  double step_s = 0;
  SimTime step_size{};                                ///< the same, rounded to nanoseconds
  std::vector<scene::FreeBody> bodies;                ///< trays first, then gears
  std::size_t tool_count = 0;                         ///< as scene::tools_of() lists them
  std::vector<std::vector<std::string>> joint_names;  ///< for each robot, from the base
  std::optional<scene::Conveyor> conveyor;
  std::optional<api::LightCurtainDescription> light_curtain;

  /// Index of the body with this name.
  [[nodiscard]] std::optional<int> find_body(std::string_view name) const;
  [[nodiscard]] bool curtain_stops_belt() const;
  [[nodiscard]] bool curtain_stops_robots() const;
};

/// Reads the settings of a scene whose robots have these models.
[[nodiscard]] CellSettings settings_of(const scene::Scene& scene,
                                       std::span<const robot::ArmModel> models);

}  // namespace aprsim::world
