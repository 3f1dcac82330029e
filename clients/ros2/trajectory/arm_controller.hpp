#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/ros2/actions/goal_table.hpp"
#include "clients/ros2/trajectory/follow_call.hpp"

namespace aprsim::ros2 {

/// The goals of one arm, executed one at a time, as ros2_controllers' JointTrajectoryController
/// does: a new goal preempts the present one, and begins once the arm stands. Thread: one.
class ArmController {
 public:
  /// Feedback per simulated second, action_monitor_rate of the controller.
  static constexpr double kFeedbackRate_hz = 20;

  /// Starts a call whose events come back by handle(), with the call's number.
  using Start = std::function<std::unique_ptr<MotionCall>(std::uint64_t call,
                                                          v1::FollowJointTrajectoryRequest)>;

  /// The motion of a goal.
  struct Motion {
    GoalId goal;
    std::vector<std::string> joint_names;  ///< in the order of the goal
    std::uint64_t call = 0;
    std::unique_ptr<MotionCall> follow;
  };

  ArmController(v1::RobotDescription robot, Start start);

  /// Takes a goal or refuses it: the result is why; empty = it is accepted.
  [[nodiscard]] std::string accept(const GoalId& id, const TrajectoryGoal& goal,
                                   const google::protobuf::Duration& now);
  /// Cancels goals, as GoalTable does.
  [[nodiscard]] GoalTable::CancelAnswer cancel(const GoalId& id,
                                               const google::protobuf::Duration& stamp);
  /// The end of a call.
  void handle(std::uint64_t call, const FollowEnd& end);
  /// Drops goals that ended long ago; true = there were some.
  bool expire();

  /// The motion that this call executes; null = none.
  [[nodiscard]] const Motion* motion_of(std::uint64_t call) const;
  [[nodiscard]] const GoalTable& goals() const { return goals_; }
  [[nodiscard]] const v1::RobotDescription& robot() const { return robot_; }

 private:
  struct Waiting {
    GoalId goal;
    std::optional<v1::FollowJointTrajectoryRequest> request;  ///< absent = only a stop
  };

  void preempt();
  void begin_waiting();
  void end_waiting(GoalState state, const std::string& why);
  void end(const GoalId& id, GoalState state, ActionResult result);

  v1::RobotDescription robot_;
  Start start_;
  GoalTable goals_;
  std::optional<Motion> motion_;
  std::optional<Waiting> waiting_;  ///< until the arm stands
  std::uint64_t calls_ = 0;
};

}  // namespace aprsim::ros2
