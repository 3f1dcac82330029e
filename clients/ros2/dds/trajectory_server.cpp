#include "clients/ros2/dds/trajectory_server.hpp"

#include "clients/ros2/dds/action_messages.hpp"

namespace aprsim::ros2 {
namespace {

constexpr std::chrono::milliseconds kFeedbackPeriod{5};
constexpr std::size_t kMostAsking = 256;  // clients that wait for results

}  // namespace

TrajectoryServer::TrajectoryServer(Node& node, const std::string& action, const Wakeup& wakeup)
    : node_(node),
      send_goal_(node, action + "/_action/send_goal", send_goal_request_type(),
                 send_goal_reply_type()),
      cancel_goal_(node, action + "/_action/cancel_goal", cancel_goal_request_type(),
                   cancel_goal_reply_type()),
      get_result_(node, action + "/_action/get_result", get_result_request_type(),
                  get_result_reply_type()),
      feedback_(node.create_writer(action + "/_action/feedback", feedback_type(), {})),
      status_(node.create_writer(action + "/_action/status", goal_status_type(),
                                 {1, Durability::kTransientLocal})) {
  for (const auto* service : {&send_goal_, &cancel_goal_, &get_result_}) {
    wakeup.attach(service->requests());
  }
  write_goal_status(status_, {});
}

TrajectoryServer::~TrajectoryServer() {
  node_.remove(feedback_);
  node_.remove(status_);
}

void TrajectoryServer::serve(ArmController& arm, const Decider& decider) {
  send_goal_.take([&](const Caller& caller, const void* sample) {
    const GoalRequest request = read_goal_request(sample);
    const bool accepted = decider.accept(request.id, request.goal).empty();
    send_goal_.reply(caller, [accepted, stamp = decider.now](auto writer, const auto& header) {
      write_goal_reply(writer, header, accepted, stamp);
    });
  });
  cancel_goal_.take([&](const Caller& caller, const void* sample) {
    const CancelRequest request = read_cancel_request(sample);
    cancel_goal_.reply(
        caller, [answer = arm.cancel(request.id, request.stamp)](auto writer, const auto& header) {
          write_cancel_reply(writer, header, answer);
        });
  });
  get_result_.take([&](const Caller& caller, const void* sample) {
    const GoalId id = read_result_request(sample);
    const GoalEntry* const goal = arm.goals().find(id);
    if (!goal || has_ended(goal->state)) return answer_result(caller, id, arm.goals());
    if (waiting_.size() == kMostAsking) waiting_.erase(waiting_.begin());
    waiting_.emplace_back(caller, id);
  });
}

/// The result of a goal that has ended, or that there is no such goal.
void TrajectoryServer::answer_result(const Caller& caller, const GoalId& id,
                                     const GoalTable& goals) {
  const GoalEntry* const found = goals.find(id);
  get_result_.reply(caller, [goal = found ? *found : GoalEntry{.state = GoalState::kUnknown}](
                                auto writer, const auto& header) {
    write_result_reply(writer, header, goal.state, goal.result);
  });
}

void TrajectoryServer::publish(const GoalTable& goals) {
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

void TrajectoryServer::publish_feedback(const GoalId& goal,
                                        const std::vector<std::string>& joint_names,
                                        const v1::TrajectoryFeedback& feedback) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_feedback_) return;
  next_feedback_ = now + kFeedbackPeriod;
  write_feedback(feedback_, goal, joint_names, feedback);
}

}  // namespace aprsim::ros2
