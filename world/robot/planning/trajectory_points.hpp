#pragma once

#include <memory>
#include <string>
#include <vector>

#include "world/api/commands/trajectory_command.hpp"
#include "world/base/result.hpp"
#include "world/robot/trajectory/stream/curve_check.hpp"
#include "world/robot/trajectory/stream/timed_motion.hpp"

namespace aprsim::robot {

/// The robot's joints in the order of the names; no names = its own order. Errors: kNotFound for
/// an unknown, doubled or missing joint.
[[nodiscard]] Result<std::vector<int>> joint_order(const ArmModel& model,
                                                   const std::vector<std::string>& names);

/// Points of a trajectory, checked for the motion from `from` on; a first point at time 0 is
/// dropped, and null is returned if there is no other. `order`: the joint of each value. Errors:
/// kInvalidArgument for the points' form, kUnreachable for a limit of the arm. Thread: any.
[[nodiscard]] Result<std::shared_ptr<const PointBlock>> read_points(
    const std::vector<api::TrajectoryPoint>& points, const std::vector<int>& order,
    const CurvePoint& from, const CurveLimits& limits);

}  // namespace aprsim::robot
