#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "clients/ros2/dds/service.hpp"
#include "clients/ros2/dds/wakeup.hpp"
#include "clients/ros2/trajectory/arm_controller.hpp"

namespace aprsim::ros2 {

/// The three services and two topics of an action control_msgs/action/FollowJointTrajectory.
/// Thread: one. Errors of DDS: std::runtime_error.
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
  ~TrajectoryServer();
  TrajectoryServer(const TrajectoryServer&) = delete;
  TrajectoryServer& operator=(const TrajectoryServer&) = delete;

  /// Takes the requests that have come, and answers them.
  void serve(ArmController& arm, const Decider& decider);
  /// Publishes the goals' states if they have changed, and results that clients wait for.
  void publish(const GoalTable& goals);
  /// Publishes feedback, at most 200 a second.
  void publish_feedback(const GoalId& goal, const std::vector<std::string>& joint_names,
                        const v1::TrajectoryFeedback& feedback);

 private:
  void answer_result(const Caller& caller, const GoalId& id, const GoalTable& goals);

  Node& node_;
  Service send_goal_, cancel_goal_, get_result_;
  dds_entity_t feedback_, status_;
  std::vector<std::pair<GoalId, GoalState>> published_;
  std::vector<std::pair<Caller, GoalId>> waiting_;  ///< for results
  std::chrono::steady_clock::time_point next_feedback_{};
};

}  // namespace aprsim::ros2
