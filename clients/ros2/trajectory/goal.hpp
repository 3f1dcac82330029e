#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <google/protobuf/duration.pb.h>

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/trajectory_service.pb.h"
#include "clients/ros2/actions/goal_table.hpp"

namespace aprsim::ros2 {

/// trajectory_msgs/msg/JointTrajectoryPoint: rad, rad/s, rad/s^2; m for prismatic joints.
struct GoalPoint {
  std::vector<double> positions, velocities, accelerations, effort;
  google::protobuf::Duration time_from_start;
};

/// control_msgs/msg/JointTolerance. 0 = the default, -1 = any.
struct GoalTolerance {
  std::string joint;
  double position = 0, velocity = 0, acceleration = 0;
};

/// A goal of control_msgs/action/FollowJointTrajectory.
struct TrajectoryGoal {
  google::protobuf::Duration start;  ///< simulated time; 0 = at once
  std::vector<std::string> joint_names;
  std::vector<GoalPoint> points;
  std::vector<GoalTolerance> path_tolerance, goal_tolerance;
  google::protobuf::Duration goal_time_tolerance;
  bool has_multi_dof = false;  ///< trajectories or tolerances of joints with several axes
};

/// Results as control_msgs numbers them.
inline constexpr std::int32_t kInvalidGoal = -1;

/// Why the robot's controller refuses a goal, with field and value; empty = it takes it. The checks
/// are those of ros2_controllers' JointTrajectoryController, and the joints' limits at each point.
[[nodiscard]] std::string refusal_of(const TrajectoryGoal& goal, const v1::RobotDescription& robot);

/// The goal as a request to the daemon; it has points and is not refused. Tolerances of 0 become
/// the controller's defaults: any on the way, and 0.01 rad/s at the end.
[[nodiscard]] v1::FollowJointTrajectoryRequest request_of(const TrajectoryGoal& goal,
                                                          const v1::RobotDescription& robot,
                                                          double feedback_rate_hz);

/// The result in ROS's numbers, with the daemon's words.
[[nodiscard]] ActionResult result_of(const v1::StreamEnd& end);

}  // namespace aprsim::ros2
