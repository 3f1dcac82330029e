#include "world/robot/controller/tool_change_sequence.hpp"

#include <utility>

namespace aprsim::robot {

void ToolChangeSequence::begin(bool open, std::int64_t lock_steps) {
  open_ = open;
  phase_ = Phase::kWaiting;
  lock_steps_ = lock_steps;
}

void ToolChangeSequence::cancel() {
  deferred_.clear();
  // A switched valve cannot be undone by cancelling the command.
  if (phase_ == Phase::kWaiting) phase_ = Phase::kIdle;
}

bool ToolChangeSequence::step(bool arm_at_rest, int tool_at_flange) {
  if (phase_ == Phase::kWaiting && arm_at_rest) phase_ = Phase::kLocking;
  // The valve switches in the first step at rest; the lock reaches its end after its own time.
  if (phase_ != Phase::kLocking || lock_steps_-- > 0) return false;
  phase_ = Phase::kIdle;
  if (open_) {
    tool_ = -1;
  } else if (tool_ < 0) {
    tool_ = tool_at_flange;
  }
  return true;
}

bool ToolChangeSequence::defer(api::Ticket ticket, const api::RobotAction& action) {
  if (deferred_.size() == kMaxDeferred) return false;
  deferred_.push_back({ticket, action});
  return true;
}

DeferredCommand ToolChangeSequence::take_deferred() {
  DeferredCommand oldest = std::move(deferred_.front());
  // At most kMaxDeferred elements: a ring buffer would gain nothing.
  deferred_.erase(deferred_.begin());
  return oldest;
}

}  // namespace aprsim::robot
