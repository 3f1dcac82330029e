#include "clients/ros2/dds/steps_server.hpp"

#include <aprsim_ros2_messages.h>
#include <aprsim_ros2_type_hashes.hpp>
#include <cstdint>
#include <iostream>

#include <fmt/format.h>

#include "clients/ros2/dds/goal_ids.hpp"
#include "clients/ros2/dds/samples.hpp"

namespace aprsim::ros2 {
namespace {

GoalId read_steps_result_request(const void* sample) {
  const auto& request =
      *static_cast<const simulation_interfaces_action_dds__SimulateSteps_GetResult_Request_*>(
          sample);
  return id_of(request.goal_id);
}

void write_steps_goal_reply(dds_entity_t writer, const ServiceHeader& header, bool accepted,
                            const google::protobuf::Duration& stamp) {
  const simulation_interfaces_action_dds__SimulateSteps_SendGoal_Response_ reply{
      header.client, header.sequence, accepted, stamp_of(stamp)};
  write_sample(writer, &reply);
}

void write_steps_result_reply(dds_entity_t writer, const ServiceHeader& header, GoalState state,
                              const ActionResult& result) {
  simulation_interfaces_action_dds__SimulateSteps_GetResult_Response_ reply{};
  reply.rmw_client = header.client;
  reply.rmw_sequence = header.sequence;
  reply.status = static_cast<char>(state);
  reply.result.result = {static_cast<std::uint8_t>(result.error_code),
                         text_of(result.error_string)};
  write_sample(writer, &reply);
}

ActionMessages steps_messages() {
  return {.send_goal_request =
              {simulation_interfaces_action_dds__SimulateSteps_SendGoal_Request__desc,
               type_hash::k_simulation_interfaces_action_SimulateSteps_SendGoal_Request},
          .send_goal_reply =
              {simulation_interfaces_action_dds__SimulateSteps_SendGoal_Response__desc,
               type_hash::k_simulation_interfaces_action_SimulateSteps_SendGoal_Response},
          .get_result_request =
              {simulation_interfaces_action_dds__SimulateSteps_GetResult_Request__desc,
               type_hash::k_simulation_interfaces_action_SimulateSteps_GetResult_Request},
          .get_result_reply =
              {simulation_interfaces_action_dds__SimulateSteps_GetResult_Response__desc,
               type_hash::k_simulation_interfaces_action_SimulateSteps_GetResult_Response},
          .feedback = {simulation_interfaces_action_dds__SimulateSteps_FeedbackMessage__desc,
                       type_hash::k_simulation_interfaces_action_SimulateSteps_FeedbackMessage},
          .read_result_request = read_steps_result_request,
          .write_goal_reply = write_steps_goal_reply,
          .write_result_reply = write_steps_result_reply};
}

}  // namespace

StepsServer::StepsServer(Node& node, const std::string& ros_namespace, const Wakeup& wakeup)
    : action_(node, ros_namespace + "/simulate_steps", steps_messages(), wakeup) {}

void StepsServer::serve(Simulation* simulation, const google::protobuf::Duration& now) {
  const auto accept = [&](const void* sample) {
    const auto& request =
        *static_cast<const simulation_interfaces_action_dds__SimulateSteps_SendGoal_Request_*>(
            sample);
    const std::string why = goals_.accept(id_of(request.goal_id), request.goal.steps, now);
    if (!why.empty()) {
      std::cerr << fmt::format("aprsim-ros2: simulate_steps refused a goal: {}\n", why);
    }
    return why.empty();
  };
  const auto cancel = [&](const CancelRequest& request) {
    return goals_.cancel(request.id, request.stamp);
  };
  action_.serve({accept, cancel, goals_.goals(), now});
  action_.publish(goals_.goals());
  const auto progress = goals_.advance([&](std::uint64_t steps) {
    return simulation ? simulation->step(steps) : SimulationResult{kFailed, "the daemon is away"};
  });
  if (progress) write_progress(*progress);
  goals_.expire();
  action_.publish(goals_.goals());
}

void StepsServer::write_progress(const StepProgress& progress) const {
  simulation_interfaces_action_dds__SimulateSteps_FeedbackMessage_ message{};
  message.goal_id = uuid_of(progress.goal);
  message.feedback.completed_steps = progress.completed;
  message.feedback.remaining_steps = progress.remaining;
  write_sample(action_.feedback(), &message);
}

}  // namespace aprsim::ros2
