#pragma once

#include <dds/dds.h>
#include <span>

#include "clients/ros2/actions/goal_table.hpp"
#include "clients/ros2/dds/node.hpp"
#include "clients/ros2/dds/service.hpp"

/// Requests, replies and messages that all actions share. Errors of DDS: std::runtime_error.
namespace aprsim::ros2 {

/// The types and samples that one action has of its own.
struct ActionMessages {
  TopicType send_goal_request, send_goal_reply, get_result_request, get_result_reply, feedback;
  /// The goal whose result a request asks for.
  GoalId (*read_result_request)(const void* sample);
  void (*write_goal_reply)(dds_entity_t writer, const ServiceHeader& header, bool accepted,
                           const google::protobuf::Duration& stamp);
  void (*write_result_reply)(dds_entity_t writer, const ServiceHeader& header, GoalState state,
                             const ActionResult& result);
};

/// A request to cancel goals.
struct CancelRequest {
  GoalId id{};
  google::protobuf::Duration stamp;
};

[[nodiscard]] TopicType cancel_goal_request_type();
[[nodiscard]] TopicType cancel_goal_reply_type();
[[nodiscard]] TopicType goal_status_type();

/// `sample`: of the type above, by DDS.
[[nodiscard]] CancelRequest read_cancel_request(const void* sample);
void write_cancel_reply(dds_entity_t writer, const ServiceHeader& header,
                        const GoalTable::CancelAnswer& answer);
void write_goal_status(dds_entity_t writer, std::span<const GoalEntry> goals);

}  // namespace aprsim::ros2
