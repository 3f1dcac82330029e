#pragma once

#include <dds/dds.h>
#include <string>
#include <vector>

#include "aprsim/v1/trajectory_service.pb.h"
#include "clients/ros2/dds/action_messages.hpp"
#include "clients/ros2/trajectory/goal.hpp"

/// Requests, replies and messages of the action control_msgs/action/FollowJointTrajectory. Errors
/// of DDS: std::runtime_error.
namespace aprsim::ros2 {

[[nodiscard]] ActionMessages trajectory_messages();

/// A request to begin a goal.
struct TrajectoryRequest {
  GoalId id{};
  TrajectoryGoal goal;
};

/// `sample`: of the type of requests for goals, by DDS.
[[nodiscard]] TrajectoryRequest read_trajectory_goal(const void* sample);
void write_trajectory_feedback(dds_entity_t writer, const GoalId& id,
                               const std::vector<std::string>& joint_names,
                               const v1::TrajectoryFeedback& feedback);

}  // namespace aprsim::ros2
