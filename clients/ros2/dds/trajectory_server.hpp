#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "clients/ros2/dds/action_server.hpp"
#include "clients/ros2/trajectory/arm_controller.hpp"

namespace aprsim::ros2 {

/// An action control_msgs/action/FollowJointTrajectory. Thread: one. Errors of DDS:
/// std::runtime_error.
class TrajectoryServer {
 public:
  /// Decides over goals.
  struct Decider {
    /// Why a goal is refused; empty = it is accepted at that time.
    std::function<std::string(const GoalId&, const TrajectoryGoal&)> accept;
    google::protobuf::Duration now;
  };

  /// `action`: its name in ROS.
  TrajectoryServer(Node& node, const std::string& action, const Wakeup& wakeup);

  /// Takes the requests that have come, and answers them.
  void serve(ArmController& arm, const Decider& decider);
  /// Publishes the goals' states if they have changed, and results that clients wait for.
  void publish(const GoalTable& goals) { action_.publish(goals); }
  /// Publishes feedback, at most 200 a second.
  void publish_feedback(const GoalId& goal, const std::vector<std::string>& joint_names,
                        const v1::TrajectoryFeedback& feedback);

 private:
  ActionServer action_;
  std::chrono::steady_clock::time_point next_feedback_{};
};

}  // namespace aprsim::ros2
