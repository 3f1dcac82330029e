#include "clients/ros2/simulation/step_goals.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

namespace aprsim::ros2 {

std::string StepGoals::accept(const GoalId& id, std::uint64_t steps,
                              const google::protobuf::Duration& now) {
  if (steps == 0) return "steps: found 0, expected at least 1";
  if (active_) return fmt::format("another goal has {} steps to take", active_->remaining);
  if (!goals_.add(id, now)) return "goal_id: the identifier is in use";
  goals_.execute(id);
  active_ = StepProgress{.goal = id, .completed = 0, .remaining = steps};
  return {};
}

GoalTable::CancelAnswer StepGoals::cancel(const GoalId& id,
                                          const google::protobuf::Duration& stamp) {
  auto answer = goals_.cancel(id, stamp);
  const bool is_meant = active_ && std::ranges::any_of(answer.goals, [&](const auto& goal) {
                          return goal.id == active_->goal;
                        });
  if (is_meant) {
    end(GoalState::kCanceled,
        {kFailed, fmt::format("cancelled after {} of {} steps", active_->completed,
                              active_->completed + active_->remaining)});
  }
  return answer;
}

std::optional<StepProgress> StepGoals::advance(const Step& step) {
  if (!active_) return std::nullopt;
  const std::uint64_t all = active_->completed + active_->remaining;
  const std::uint64_t batch = std::min(active_->remaining, all <= kMostSingle ? 1 : kBatch);
  auto taken = step(batch);
  if (taken.code != kOk) {
    end(GoalState::kAborted, std::move(taken));
    return std::nullopt;
  }
  active_->completed += batch;
  active_->remaining -= batch;
  const StepProgress progress = *active_;
  if (progress.remaining == 0) end(GoalState::kSucceeded, {});
  return progress;
}

void StepGoals::end(GoalState state, SimulationResult result) {
  goals_.end(active_->goal, state, {result.code, std::move(result.message)},
             std::chrono::steady_clock::now());
  active_.reset();
}

void StepGoals::expire() { goals_.expire(std::chrono::steady_clock::now()); }

}  // namespace aprsim::ros2
