#include "clients/ros2/dds/trajectory_server.hpp"

#include "clients/ros2/dds/trajectory_messages.hpp"

namespace aprsim::ros2 {
namespace {

constexpr std::chrono::milliseconds kFeedbackPeriod{5};

}  // namespace

TrajectoryServer::TrajectoryServer(Node& node, const std::string& action, const Wakeup& wakeup)
    : action_(node, action, trajectory_messages(), wakeup) {}

void TrajectoryServer::serve(ArmController& arm, const Decider& decider) {
  const auto accept = [&](const void* sample) {
    const TrajectoryRequest request = read_trajectory_goal(sample);
    return decider.accept(request.id, request.goal).empty();
  };
  const auto cancel = [&](const CancelRequest& request) {
    return arm.cancel(request.id, request.stamp);
  };
  action_.serve({accept, cancel, arm.goals(), decider.now});
}

void TrajectoryServer::publish_feedback(const GoalId& goal,
                                        const std::vector<std::string>& joint_names,
                                        const v1::TrajectoryFeedback& feedback) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_feedback_) return;
  next_feedback_ = now + kFeedbackPeriod;
  write_trajectory_feedback(action_.feedback(), goal, joint_names, feedback);
}

}  // namespace aprsim::ros2
