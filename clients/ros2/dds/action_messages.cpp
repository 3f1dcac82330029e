#include "clients/ros2/dds/action_messages.hpp"

#include <aprsim_ros2_type_hashes.hpp>
#include <vector>

#include "clients/ros2/dds/goal_ids.hpp"
#include "clients/ros2/dds/samples.hpp"

namespace aprsim::ros2 {
namespace {

action_msgs_msg_dds__GoalInfo_ info_of(const GoalEntry& goal) {
  return {uuid_of(goal.id), stamp_of(goal.stamp)};
}

}  // namespace

TopicType cancel_goal_request_type() {
  return {action_msgs_srv_dds__CancelGoal_Request__desc,
          type_hash::k_action_msgs_srv_CancelGoal_Request};
}
TopicType cancel_goal_reply_type() {
  return {action_msgs_srv_dds__CancelGoal_Response__desc,
          type_hash::k_action_msgs_srv_CancelGoal_Response};
}
TopicType goal_status_type() {
  return {action_msgs_msg_dds__GoalStatusArray__desc, type_hash::k_action_msgs_msg_GoalStatusArray};
}

CancelRequest read_cancel_request(const void* sample) {
  const auto& request = *static_cast<const action_msgs_srv_dds__CancelGoal_Request_*>(sample);
  return {id_of(request.goal_info.goal_id), time_of(request.goal_info.stamp)};
}

void write_cancel_reply(dds_entity_t writer, const ServiceHeader& header,
                        const GoalTable::CancelAnswer& answer) {
  std::vector<action_msgs_msg_dds__GoalInfo_> goals;
  for (const auto& goal : answer.goals) goals.push_back(info_of(goal));
  action_msgs_srv_dds__CancelGoal_Response_ reply{};
  reply.rmw_client = header.client;
  reply.rmw_sequence = header.sequence;
  reply.return_code = static_cast<char>(answer.return_code);
  refer(reply.goals_canceling, goals);
  write_sample(writer, &reply);
}

void write_goal_status(dds_entity_t writer, std::span<const GoalEntry> goals) {
  std::vector<action_msgs_msg_dds__GoalStatus_> states;
  for (const auto& goal : goals) states.push_back({info_of(goal), static_cast<char>(goal.state)});
  action_msgs_msg_dds__GoalStatusArray_ message{};
  refer(message.status_list, states);
  write_sample(writer, &message);
}

}  // namespace aprsim::ros2
