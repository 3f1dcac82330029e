#include "clients/ros2/actions/goal_table.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace aprsim::ros2 {
namespace {

constexpr std::int8_t kUnknownGoal = 2;     // ERROR_UNKNOWN_GOAL_ID
constexpr std::int8_t kTerminatedGoal = 3;  // ERROR_GOAL_TERMINATED

std::tuple<std::int64_t, std::int32_t> as_order(const google::protobuf::Duration& time) {
  return {time.seconds(), time.nanos()};
}

bool is_cancelable(GoalState state) {
  return state == GoalState::kAccepted || state == GoalState::kExecuting;
}

}  // namespace

bool has_ended(GoalState state) { return state >= GoalState::kSucceeded; }

GoalEntry* GoalTable::at(const GoalId& id) {
  const auto found = std::ranges::find(goals_, id, &GoalEntry::id);
  return found == goals_.end() ? nullptr : &*found;
}

const GoalEntry* GoalTable::find(const GoalId& id) const {
  const auto found = std::ranges::find(goals_, id, &GoalEntry::id);
  return found == goals_.end() ? nullptr : &*found;
}

bool GoalTable::add(const GoalId& id, const google::protobuf::Duration& stamp) {
  if (find(id)) return false;
  goals_.push_back({.id = id, .stamp = stamp, .result = {}});
  return true;
}

void GoalTable::execute(const GoalId& id) {
  GoalEntry* const goal = at(id);
  if (goal && goal->state == GoalState::kAccepted) goal->state = GoalState::kExecuting;
}

void GoalTable::end(const GoalId& id, GoalState state, ActionResult result,
                    std::chrono::steady_clock::time_point now) {
  GoalEntry* const goal = at(id);
  if (!goal || has_ended(goal->state)) return;
  goal->state = state;
  goal->result = std::move(result);
  goal->ended_at = now;
}

GoalTable::CancelAnswer GoalTable::cancel(const GoalId& id,
                                          const google::protobuf::Duration& stamp) {
  CancelAnswer answer;
  const bool has_id = id != GoalId{};
  const bool has_stamp = as_order(stamp) != as_order({});
  if (has_id && !has_stamp) {
    const GoalEntry* const goal = find(id);
    if (!goal) answer.return_code = kUnknownGoal;
    if (goal && !is_cancelable(goal->state)) answer.return_code = kTerminatedGoal;
  }
  for (auto& goal : goals_) {
    const bool is_meant = has_id && goal.id == id;
    const bool is_earlier = has_stamp && as_order(goal.stamp) <= as_order(stamp);
    if (!is_meant && !is_earlier && (has_id || has_stamp)) continue;
    if (!is_cancelable(goal.state)) continue;
    goal.state = GoalState::kCanceling;
    answer.goals.push_back(goal);
  }
  return answer;
}

bool GoalTable::expire(std::chrono::steady_clock::time_point now) {
  auto ended = static_cast<std::size_t>(
      std::ranges::count_if(goals_, [](const auto& goal) { return has_ended(goal.state); }));
  return std::erase_if(goals_, [&](const GoalEntry& goal) {
           if (!has_ended(goal.state)) return false;
           const bool is_over = now - goal.ended_at >= kKept || ended > kMostEnded;
           if (is_over) --ended;
           return is_over;
         }) > 0;
}

}  // namespace aprsim::ros2
