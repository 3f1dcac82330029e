#pragma once

#include <dds/dds.h>
#include <span>
#include <string>

#include "aprsim/v1/trajectory_service.pb.h"
#include "clients/ros2/dds/node.hpp"
#include "clients/ros2/dds/service.hpp"
#include "clients/ros2/trajectory/goal_table.hpp"

/// Requests, replies and messages of the action control_msgs/action/FollowJointTrajectory. Errors
/// of DDS: std::runtime_error.
namespace aprsim::ros2 {

[[nodiscard]] TopicType send_goal_request_type();
[[nodiscard]] TopicType send_goal_reply_type();
[[nodiscard]] TopicType cancel_goal_request_type();
[[nodiscard]] TopicType cancel_goal_reply_type();
[[nodiscard]] TopicType get_result_request_type();
[[nodiscard]] TopicType get_result_reply_type();
[[nodiscard]] TopicType feedback_type();
[[nodiscard]] TopicType goal_status_type();

/// A request to begin a goal.
struct GoalRequest {
  GoalId id{};
  TrajectoryGoal goal;
};
/// A request to cancel goals.
struct CancelRequest {
  GoalId id{};
  google::protobuf::Duration stamp;
};

/// `sample`: of the type above, by DDS.
[[nodiscard]] GoalRequest read_goal_request(const void* sample);
[[nodiscard]] CancelRequest read_cancel_request(const void* sample);
[[nodiscard]] GoalId read_result_request(const void* sample);

void write_goal_reply(dds_entity_t writer, const ServiceHeader& header, bool accepted,
                      const google::protobuf::Duration& stamp);
void write_cancel_reply(dds_entity_t writer, const ServiceHeader& header,
                        const GoalTable::CancelAnswer& answer);
void write_result_reply(dds_entity_t writer, const ServiceHeader& header, GoalState state,
                        const TrajectoryResult& result);
void write_goal_status(dds_entity_t writer, std::span<const GoalEntry> goals);
void write_feedback(dds_entity_t writer, const GoalId& id,
                    const std::vector<std::string>& joint_names,
                    const v1::TrajectoryFeedback& feedback);

}  // namespace aprsim::ros2
