#include "clients/ros2/dds/action_server.hpp"

namespace aprsim::ros2 {
namespace {

constexpr std::size_t kMostAsking = 256;  // clients that wait for results

}  // namespace

ActionServer::ActionServer(Node& node, const std::string& action, const ActionMessages& messages,
                           const Wakeup& wakeup)
    : node_(node),
      messages_(messages),
      send_goal_(node, action + "/_action/send_goal", messages.send_goal_request,
                 messages.send_goal_reply),
      cancel_goal_(node, action + "/_action/cancel_goal", cancel_goal_request_type(),
                   cancel_goal_reply_type()),
      get_result_(node, action + "/_action/get_result", messages.get_result_request,
                  messages.get_result_reply),
      feedback_(node.create_writer(action + "/_action/feedback", messages.feedback, {})),
      status_(node.create_writer(action + "/_action/status", goal_status_type(),
                                 {1, Durability::kTransientLocal})) {
  for (const auto* service : {&send_goal_, &cancel_goal_, &get_result_}) {
    wakeup.attach(service->requests());
  }
  write_goal_status(status_, {});
}

ActionServer::~ActionServer() {
  node_.remove(feedback_);
  node_.remove(status_);
}

void ActionServer::serve(const Goals& goals) {
  send_goal_.take([&](const Caller& caller, const void* sample) {
    const bool accepted = goals.accept(sample);
    send_goal_.reply(
        caller, [write = messages_.write_goal_reply, accepted, stamp = goals.now](
                    auto writer, const auto& header) { write(writer, header, accepted, stamp); });
  });
  cancel_goal_.take([&](const Caller& caller, const void* sample) {
    cancel_goal_.reply(caller, [answer = goals.cancel(read_cancel_request(sample))](
                                   auto writer, const auto& header) {
      write_cancel_reply(writer, header, answer);
    });
  });
  get_result_.take([&](const Caller& caller, const void* sample) {
    const GoalId id = messages_.read_result_request(sample);
    const GoalEntry* const goal = goals.table.find(id);
    if (!goal || has_ended(goal->state)) return answer_result(caller, id, goals.table);
    if (waiting_.size() == kMostAsking) waiting_.erase(waiting_.begin());
    waiting_.emplace_back(caller, id);
  });
}

/// The result of a goal that has ended, or that there is no such goal.
void ActionServer::answer_result(const Caller& caller, const GoalId& id, const GoalTable& goals) {
  const GoalEntry* const found = goals.find(id);
  get_result_.reply(caller, [write = messages_.write_result_reply,
                             goal = found ? *found : GoalEntry{.state = GoalState::kUnknown}](
                                auto writer, const auto& header) {
    write(writer, header, goal.state, goal.result);
  });
}

void ActionServer::publish(const GoalTable& goals) {
  std::vector<std::pair<GoalId, GoalState>> states;
  for (const auto& goal : goals.goals()) states.emplace_back(goal.id, goal.state);
  if (states == published_) return;
  published_ = std::move(states);
  write_goal_status(status_, goals.goals());
  std::erase_if(waiting_, [&](const auto& one) {
    const GoalEntry* const goal = goals.find(one.second);
    if (goal && !has_ended(goal->state)) return false;
    answer_result(one.first, one.second, goals);
    return true;
  });
}

}  // namespace aprsim::ros2
