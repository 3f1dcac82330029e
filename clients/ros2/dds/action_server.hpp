#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "clients/ros2/dds/action_messages.hpp"
#include "clients/ros2/dds/service.hpp"
#include "clients/ros2/dds/wakeup.hpp"

namespace aprsim::ros2 {

/// The three services and two topics of an action of ROS 2. Thread: one. Errors of DDS:
/// std::runtime_error.
class ActionServer {
 public:
  /// The goals that requests are about.
  struct Goals {
    std::function<bool(const void* sample)> accept;  ///< a request for a goal
    std::function<GoalTable::CancelAnswer(const CancelRequest& request)> cancel;
    const GoalTable& table;
    google::protobuf::Duration now;
  };

  /// `action`: its name in ROS.
  ActionServer(Node& node, const std::string& action, const ActionMessages& messages,
               const Wakeup& wakeup);
  ~ActionServer();
  ActionServer(const ActionServer&) = delete;
  ActionServer& operator=(const ActionServer&) = delete;

  /// The writer of feedback.
  [[nodiscard]] dds_entity_t feedback() const { return feedback_; }
  /// Takes the requests that have come, and answers them.
  void serve(const Goals& goals);
  /// Publishes the goals' states if they have changed, and results that clients wait for.
  void publish(const GoalTable& goals);

 private:
  void answer_result(const Caller& caller, const GoalId& id, const GoalTable& goals);

  Node& node_;
  const ActionMessages messages_;
  Service send_goal_, cancel_goal_, get_result_;
  dds_entity_t feedback_, status_;
  std::vector<std::pair<GoalId, GoalState>> published_;
  std::vector<std::pair<Caller, GoalId>> waiting_;  ///< for results
};

}  // namespace aprsim::ros2
