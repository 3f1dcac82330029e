#include "clients/ros2/trajectory/goal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>

#include <fmt/format.h>

namespace aprsim::ros2 {
namespace {

constexpr double kNs = 1e-9;
constexpr double kStoppedVelocity_rad_s = 0.01;  // constraints.stopped_velocity_tolerance
constexpr double kAnyTolerance = -1;
constexpr const char* kCommander = "ROS 2 FollowJointTrajectory";

double seconds_of(const google::protobuf::Duration& time) {
  return static_cast<double>(time.seconds()) + kNs * time.nanos();
}

/// The joint of a name; null = the robot has none.
const v1::JointDescription* find_joint(const v1::RobotDescription& robot, const std::string& name) {
  const auto found =
      std::ranges::find_if(robot.joints(), [&](const auto& joint) { return joint.name() == name; });
  return found == robot.joints().end() ? nullptr : &*found;
}

std::string check_names(const TrajectoryGoal& goal, const v1::RobotDescription& robot) {
  const auto& names = goal.joint_names;
  if (names.empty() && goal.points.empty()) return {};
  for (const auto& name : names) {
    if (!find_joint(robot, name)) {
      return fmt::format("joint_names: found \"{}\", which is no joint of {}", name, robot.name());
    }
  }
  const std::set<std::string> different(names.begin(), names.end());
  const auto joints = static_cast<std::size_t>(robot.joints_size());
  if (names.size() == joints && different.size() == joints) return {};
  return fmt::format("joint_names: found {} names, {} of them different, expected all {} joints",
                     names.size(), different.size(), joints);
}

std::string check_values(const std::vector<double>& values, std::string_view field,
                         std::size_t point, std::size_t joints) {
  if (values.size() != joints) {
    return fmt::format("points[{}].{}: found {} values, expected {}", point, field, values.size(),
                       joints);
  }
  for (const double value : values) {
    if (std::isfinite(value)) continue;
    return fmt::format("points[{}].{}: found {}, expected a finite number", point, field, value);
  }
  return {};
}

/// Position and velocity of each joint of a point against the joint's limits.
std::string check_limits(const TrajectoryGoal& goal, std::size_t index,
                         const v1::RobotDescription& robot) {
  constexpr double kRounding = 1e-9;
  const GoalPoint& point = goal.points[index];
  for (std::size_t i = 0; i < goal.joint_names.size(); ++i) {
    const auto& joint = *find_joint(robot, goal.joint_names[i]);
    const double position = point.positions[i];
    if (position < joint.lower_rad() - kRounding || position > joint.upper_rad() + kRounding) {
      return fmt::format("points[{}].positions: {} is {:.6g}, its limits are {:.6g} and {:.6g}",
                         index, joint.name(), position, joint.lower_rad(), joint.upper_rad());
    }
    if (point.velocities.empty()) continue;
    if (std::abs(point.velocities[i]) > joint.max_speed_rad_s() + kRounding) {
      return fmt::format("points[{}].velocities: {} is {:.6g}, its limit is {:.6g}", index,
                         joint.name(), point.velocities[i], joint.max_speed_rad_s());
    }
  }
  return {};
}

std::string check_point(const TrajectoryGoal& goal, std::size_t index,
                        const v1::RobotDescription& robot) {
  const GoalPoint& point = goal.points[index];
  const auto joints = goal.joint_names.size();
  if (auto why = check_values(point.positions, "positions", index, joints); !why.empty()) {
    return why;
  }
  for (const auto& [values, field] : {std::pair{&point.velocities, "velocities"},
                                      std::pair{&point.accelerations, "accelerations"}}) {
    if (values->empty()) continue;
    if (auto why = check_values(*values, field, index, joints); !why.empty()) return why;
  }
  if (point.velocities.empty() && !point.accelerations.empty()) {
    return fmt::format(
        "points[{}].accelerations: found {} values, expected none without velocities", index,
        point.accelerations.size());
  }
  if (!point.effort.empty()) {
    return fmt::format("points[{}].effort: found {} values, expected none", index,
                       point.effort.size());
  }
  const double time_s = seconds_of(point.time_from_start);
  const double before_s = index > 0 ? seconds_of(goal.points[index - 1].time_from_start) : 0;
  if (index > 0 ? time_s <= before_s : time_s < 0) {
    return fmt::format("points[{}].time_from_start: found {} s, expected {} {} s", index, time_s,
                       index > 0 ? "more than" : "at least", before_s);
  }
  return check_limits(goal, index, robot);
}

std::string check_end(const TrajectoryGoal& goal) {
  const auto& velocities = goal.points.back().velocities;
  for (std::size_t i = 0; i < velocities.size(); ++i) {
    if (std::abs(velocities[i]) <= std::numeric_limits<float>::epsilon()) continue;
    return fmt::format("points[{}].velocities: {} is {:.6g} at the end, expected 0",
                       goal.points.size() - 1, goal.joint_names[i], velocities[i]);
  }
  return {};
}

std::string check_tolerances(const std::vector<GoalTolerance>& tolerances, std::string_view field,
                             const v1::RobotDescription& robot) {
  for (const auto& tolerance : tolerances) {
    if (!find_joint(robot, tolerance.joint)) {
      return fmt::format("{}: found \"{}\", which is no joint of {}", field, tolerance.joint,
                         robot.name());
    }
    for (const double value : {tolerance.position, tolerance.velocity, tolerance.acceleration}) {
      if (std::isfinite(value) && (value >= 0 || value == kAnyTolerance)) continue;
      return fmt::format("{}: {} has {}, expected -1, 0 or more", field, tolerance.joint, value);
    }
    if (tolerance.acceleration > 0) {
      return fmt::format("{}: {} has an acceleration tolerance of {}, expected none", field,
                         tolerance.joint, tolerance.acceleration);
    }
  }
  return {};
}

/// One tolerance for each joint of the goal.
void write_tolerances(const std::vector<GoalTolerance>& tolerances, const TrajectoryGoal& goal,
                      double default_velocity,
                      google::protobuf::RepeatedPtrField<v1::JointTolerance>& out) {
  const auto resolved = [](double value, double otherwise) {
    return value > 0 ? value : value == kAnyTolerance ? 0 : otherwise;
  };
  for (const auto& name : goal.joint_names) {
    const auto found = std::ranges::find(tolerances, name, &GoalTolerance::joint);
    const GoalTolerance given = found == tolerances.end() ? GoalTolerance{} : *found;
    auto& tolerance = *out.Add();
    tolerance.set_position_rad(resolved(given.position, 0));
    tolerance.set_velocity_rad_s(resolved(given.velocity, default_velocity));
  }
}

}  // namespace

std::string refusal_of(const TrajectoryGoal& goal, const v1::RobotDescription& robot) {
  if (goal.has_multi_dof) {
    return "multi_dof_trajectory: found values, expected none: all joints have one axis";
  }
  if (auto why = check_names(goal, robot); !why.empty()) return why;
  if (auto why = check_tolerances(goal.path_tolerance, "path_tolerance", robot); !why.empty()) {
    return why;
  }
  if (auto why = check_tolerances(goal.goal_tolerance, "goal_tolerance", robot); !why.empty()) {
    return why;
  }
  if (const double time_s = seconds_of(goal.goal_time_tolerance);
      time_s < 0 && time_s != kAnyTolerance) {
    return fmt::format("goal_time_tolerance: found {} s, expected -1, 0 or more", time_s);
  }
  for (std::size_t i = 0; i < goal.points.size(); ++i) {
    if (auto why = check_point(goal, i, robot); !why.empty()) return why;
  }
  return goal.points.empty() ? "" : check_end(goal);
}

v1::FollowJointTrajectoryRequest request_of(const TrajectoryGoal& goal,
                                            const v1::RobotDescription& robot,
                                            double feedback_rate_hz) {
  v1::FollowJointTrajectoryRequest request;
  request.set_robot(robot.name());
  auto& trajectory = *request.mutable_trajectory();
  trajectory.set_commander(kCommander);
  for (const auto& name : goal.joint_names) trajectory.add_joint_names(name);
  for (const auto& point : goal.points) {
    auto& out = *trajectory.add_points();
    *out.mutable_time() = point.time_from_start;
    out.mutable_position_rad()->Assign(point.positions.begin(), point.positions.end());
    out.mutable_velocity_rad_s()->Assign(point.velocities.begin(), point.velocities.end());
    out.mutable_acceleration_rad_s2()->Assign(point.accelerations.begin(),
                                              point.accelerations.end());
  }
  if (seconds_of(goal.start) != 0) *trajectory.mutable_start() = goal.start;
  write_tolerances(goal.path_tolerance, goal, 0, *trajectory.mutable_path_tolerance());
  write_tolerances(goal.goal_tolerance, goal, kStoppedVelocity_rad_s,
                   *trajectory.mutable_goal_tolerance());
  if (seconds_of(goal.goal_time_tolerance) > 0) {
    *trajectory.mutable_goal_time_tolerance() = goal.goal_time_tolerance;
  }
  request.mutable_feedback_period()->set_nanos(
      static_cast<std::int32_t>(std::lround(1 / (kNs * feedback_rate_hz))));
  return request;
}

ActionResult result_of(const v1::StreamEnd& end) {
  switch (end.result()) {
    case v1::STREAM_RESULT_SUCCESSFUL:
      return {0, "Goal successfully reached!"};
    case v1::STREAM_RESULT_INVALID_JOINTS:
      return {-2, end.text()};
    case v1::STREAM_RESULT_OLD_HEADER_TIMESTAMP:
      return {-3, end.text()};
    case v1::STREAM_RESULT_PATH_TOLERANCE_VIOLATED:
      return {-4, end.text()};
    case v1::STREAM_RESULT_GOAL_TOLERANCE_VIOLATED:
      return {-5, end.text()};
    default:
      return {kInvalidGoal, end.text()};
  }
}

}  // namespace aprsim::ros2
