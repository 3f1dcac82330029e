#include "world/robot/controller/guard_monitor.hpp"

#include <algorithm>

#include "world/api/snapshot/signal_value.hpp"

namespace aprsim::robot {
namespace {

/// Whether the guard's condition is met.
bool holds(const api::Guard& guard, double value, double start) {
  switch (guard.limit) {
    case api::GuardLimit::kOverMax:
      return value > guard.value;
    case api::GuardLimit::kUnderMin:
      return value < guard.value;
    case api::GuardLimit::kIncreased:
      return value - start > guard.value;
    case api::GuardLimit::kDecreased:
      break;
  }
  return start - value > guard.value;
}

}  // namespace

void GuardMonitor::begin(api::Ticket ticket, std::span<const api::Guard> guards) {
  // A fixed capacity: the check runs in every step and must not allocate.
  const std::size_t count = std::min(guards.size(), api::kMaxGuards);
  active_ = true;
  triggered_ = started_ = false;
  triggered_at_.reset();
  reaction_at_.reset();
  std::copy_n(guards.begin(), count, guards_.begin());
  state_.ticket = ticket;
  state_.count = count;
  state_.guards = {};
}

std::optional<std::size_t> GuardMonitor::check(const api::RobotSnapshot& robot, SimTime now,
                                               SimTime delay) {
  if (reaction_at_) {
    if (now < *reaction_at_) return std::nullopt;
    reaction_at_.reset();
    return state_.trigger_guard;
  }
  if (!active_) return std::nullopt;
  for (std::size_t i = 0; i < state_.count; ++i) {
    const api::Guard& guard = guards_[i];
    if (started_ && now < due_[i]) continue;
    const double value = api::value_of(guard.signal, robot);
    // Increases and decreases are measured from the first value.
    if (!started_) start_[i] = value;
    // From the time it was due: a period that is no multiple of the step must not drift.
    due_[i] = (started_ ? due_[i] : now) + guard.recheck;
    // A recheck period shorter than the step means every step.
    if (due_[i] <= now) due_[i] = now;
    state_.guards[i] = {state_.guards[i].checks + 1, now, value};
    if (!holds(guard, value, start_[i])) continue;
    // Trigger: one a command.
    active_ = false;
    triggered_ = true;
    triggered_at_ = now;
    ++state_.triggers;
    state_.stop_time = SimTime::zero();
    state_.trigger_guard = i;
    state_.trigger_value = value;
    state_.trigger_X_RT = robot.X_RT;
    if (delay <= SimTime::zero()) return i;
    reaction_at_ = now + delay;
    return std::nullopt;
  }
  started_ = true;
  return std::nullopt;
}

void GuardMonitor::at_rest(SimTime now) {
  if (!triggered_at_) return;
  state_.stop_time = now - *triggered_at_;
  triggered_at_.reset();
}

const api::Guard* GuardMonitor::missing_trigger() const {
  if (triggered_) return nullptr;
  for (std::size_t i = 0; i < state_.count; ++i) {
    if (guards_[i].require_trigger) return &guards_[i];
  }
  return nullptr;
}

}  // namespace aprsim::robot
