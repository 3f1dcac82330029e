#include "clients/ros2/trajectory/arm_controller.hpp"

#include <chrono>
#include <utility>

namespace aprsim::ros2 {
namespace {

constexpr const char* kPreempted = "Current goal preempted by new incoming action.";
constexpr const char* kCancelled = "The goal was cancelled; the robot holds its position.";
constexpr const char* kStopped = "The trajectory has no points: the robot holds its position.";

}  // namespace

ArmController::ArmController(v1::RobotDescription robot, Start start)
    : robot_(std::move(robot)), start_(std::move(start)) {}

std::string ArmController::accept(const GoalId& id, const TrajectoryGoal& goal,
                                  const google::protobuf::Duration& now) {
  if (auto why = refusal_of(goal, robot_); !why.empty()) return why;
  if (!goals_.add(id, now)) return "goal_id: the identifier is in use";
  preempt();
  waiting_ = Waiting{.goal = id, .request = {}};
  if (!goal.points.empty()) waiting_->request = request_of(goal, robot_, kFeedbackRate_hz);
  if (!motion_) begin_waiting();
  return {};
}

/// The present goals end; the arm stops.
void ArmController::preempt() {
  end_waiting(GoalState::kAborted, kPreempted);
  if (!motion_) return;
  motion_->follow->cancel();
  const GoalEntry* const goal = goals_.find(motion_->goal);
  // A goal that is being cancelled ends as such once the arm stands.
  if (goal && goal->state == GoalState::kCanceling) return;
  end(motion_->goal, GoalState::kAborted, {kInvalidGoal, kPreempted});
}

void ArmController::end_waiting(GoalState state, const std::string& why) {
  if (!waiting_) return;
  end(waiting_->goal, state, {state == GoalState::kAborted ? kInvalidGoal : 0, why});
  waiting_.reset();
}

void ArmController::end(const GoalId& id, GoalState state, ActionResult result) {
  goals_.end(id, state, std::move(result), std::chrono::steady_clock::now());
}

void ArmController::begin_waiting() {
  if (!waiting_) return;
  goals_.execute(waiting_->goal);
  if (!waiting_->request) return end_waiting(GoalState::kSucceeded, kStopped);
  const std::uint64_t call = ++calls_;
  const auto& names = waiting_->request->trajectory().joint_names();
  motion_ = Motion{.goal = waiting_->goal,
                   .joint_names = {names.begin(), names.end()},
                   .call = call,
                   .follow = {}};
  motion_->follow = start_(call, *std::move(waiting_->request));
  waiting_.reset();
}

GoalTable::CancelAnswer ArmController::cancel(const GoalId& id,
                                              const google::protobuf::Duration& stamp) {
  auto answer = goals_.cancel(id, stamp);
  for (const auto& goal : answer.goals) {
    if (waiting_ && waiting_->goal == goal.id) end_waiting(GoalState::kCanceled, kCancelled);
    if (motion_ && motion_->goal == goal.id) motion_->follow->cancel();
  }
  return answer;
}

void ArmController::handle(std::uint64_t call, const FollowEnd& ended) {
  if (!motion_ || motion_->call != call) return;
  if (ended.succeeded) {
    end(motion_->goal, GoalState::kSucceeded, ended.result);
  } else if (ended.cancelled) {
    end(motion_->goal, GoalState::kCanceled, {0, kCancelled});
  } else {
    end(motion_->goal, GoalState::kAborted, ended.result);
  }
  motion_.reset();
  begin_waiting();
}

bool ArmController::expire() { return goals_.expire(std::chrono::steady_clock::now()); }

const ArmController::Motion* ArmController::motion_of(std::uint64_t call) const {
  return motion_ && motion_->call == call ? &*motion_ : nullptr;
}

}  // namespace aprsim::ros2
