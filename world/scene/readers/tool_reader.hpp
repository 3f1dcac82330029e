#pragma once

#include <array>
#include <string>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/scene.hpp"

/// Tools, tool changers, force sensors and holders of a scene file.
namespace aprsim::scene {

/// A fork of two bars on which the palm of a tool rests.
struct Holder {
  std::string name;
  Pose X_WQ;          ///< of the coupling of a tool that rests in it
  double seat_m = 0;  ///< from the coupling to the bars' upper faces, along the approach
  std::array<StaticBox, 2> bars;
};

/// Without a place.
[[nodiscard]] Tool read_tool(const yaml::Map& keys);
inline constexpr std::array<std::string_view, 5> kToolKeys = {"name", "kind", "gripper", "cup",
                                                              "tool_point"};

[[nodiscard]] ToolChanger read_tool_changer(const yaml::Node& node);

/// Without errors where the key is absent.
[[nodiscard]] ForceSensor read_force_sensor(const yaml::Node& node);

[[nodiscard]] Holder read_holder(const yaml::Map& keys, const std::string& name);
inline constexpr std::array<std::string_view, 8> kHolderKeys = {
    "name", "xyz_m", "rpy_deg", "seat_m", "gap_m", "bar_m", "bars_yaw_deg", "tool"};

}  // namespace aprsim::scene
