#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "world/api/values/pose.hpp"
#include "world/api/values/wire_joint.hpp"
#include "world/base/yaml/yaml_reader.hpp"

/// How a robot's controller speaks CRCL: the keys crcl_joints and crcl_tool_point of a robot.
namespace aprsim::scene {

/// The list of the joints in CRCL's order; empty when absent. Each is a map:
///
///   joint            of the model, from 1; or none for a number that no joint has
///   pulses_per_deg   the unit is pulses of the drive; absent: an angle in the connection's unit
///   reversed         true: it turns the other way than the model's
///   offset_deg       of the model's joint where this one is 0
///   coupling         a map {NUMBER: FACTOR}: the model's joint is at its own angle and so much of
///                    the angle of CRCL joint NUMBER
///   limits           [LOWER, UPPER] in its unit, pulses or degrees, that the robot states and
///                    keeps beside those of the model; absent: what the model's leave
[[nodiscard]] std::vector<api::WireJoint> read_crcl_joints(const yaml::Node& node,
                                                           std::size_t joint_count);

/// `tool` (none; between the finger tips, and the flange while the tool changer is open; the
/// default), `flange`, or a map of xyz_m and rpy_deg in the flange.
[[nodiscard]] std::optional<Pose> read_tool_point(const yaml::Node& node);

}  // namespace aprsim::scene
