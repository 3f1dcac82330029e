#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "crcl/units.hpp"
#include "world/api/cell_description.hpp"
#include "world/api/error.hpp"
#include "world/api/robot_command.hpp"

/// What happens to targets outside the limits that a robot reports, before the robot plans.
namespace aprsim::crcl_server {

/// Where the tool point may be sent, in the robot's reference frame [m].
struct CartesianLimits {
  Eigen::Vector3d min_R = Eigen::Vector3d::Zero(), max_R = Eigen::Vector3d::Zero();
};

/// The robot's reach, narrowed by what the configuration gives.
[[nodiscard]] CartesianLimits cartesian_limits(const api::RobotDescription& robot,
                                               const std::optional<Eigen::Vector3d>& min_R,
                                               const std::optional<Eigen::Vector3d>& max_R);

/// Moves the target onto the nearest point within the limits when `clamp`, and then says what it
/// did; else refuses a target outside, naming axis, value, limit and unit. Nothing to say when the
/// target is within. The robot itself still refuses what it cannot reach.
[[nodiscard]] Result<std::optional<std::string>> fit(Pose& X_RT, const CartesianLimits& limits,
                                                     bool clamp, crcl::LengthUnit unit);
/// The same for joint limits, which the robot itself refuses when not `clamp`.
[[nodiscard]] Result<std::optional<std::string>> fit(api::MoveJoints& move,
                                                     const api::RobotDescription& robot, bool clamp,
                                                     crcl::AngleUnit unit);

}  // namespace aprsim::crcl_server
