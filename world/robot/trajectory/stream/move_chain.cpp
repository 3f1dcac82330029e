#include "world/robot/trajectory/stream/move_chain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace aprsim::robot {
namespace {

/// Differences of samples are larger than the derivatives that they stand for, by rounding.
constexpr double kSlack = 1 + 1e-3;

}  // namespace

/// A synchronised motion: the slowest joint has its share of its speed, accelerations are full.
JointMotion MoveChain::planned(const ChainedMove& move, const JointVector& from,
                               const StepInput& input) const {
  JointMove task{
      .start = from, .target = move.target, .limits = input.limits, .maximum = input.limits};
  task.limits.speed *= move.speed;
  JointMotion motion;
  motion.plan(task);
  motion.set_speed(speed_);
  return motion;
}

ChainedMove MoveChain::take_waiting() {
  ChainedMove move = std::move(waiting_.front());
  waiting_.erase(waiting_.begin());
  return move;
}

void MoveChain::begin_next(const StepInput& input, const JointVector& q) {
  const ChainedMove move = take_waiting();
  present_ = planned(move, q, input);
  rounding_ = move.rounding;
  running_ = true;
}

/// The overlap begins when the rest of the present move is the wanted share of its deceleration.
void MoveChain::try_overlap(const StepInput& input) {
  if (!running_ || overlaps_ || waiting_.empty() || rounding_ <= 0 || speed_ <= 0) return;
  if (present_.duration() - present_.time() > rounding_ * present_.deceleration_s()) return;
  JointMotion next = planned(waiting_.front(), present_.end(), input);
  if (!sum_is_within(input, next)) return;
  next_ = next;
  next_rounding_ = take_waiting().rounding;
  overlaps_ = true;
}

/// Velocities and accelerations of the sum, by differences from step to step of the overlap.
bool MoveChain::sum_is_within(const StepInput& input, const JointMotion& next) const {
  const double rest = present_.duration() - present_.time();
  const double h = input.step_s;
  JointVector first, second;
  JointVector older, old;
  for (double t = -2 * h; t <= rest + 2 * h; t += h) {
    present_.at(std::max(present_.time() + t, 0.0), first);
    next.at(std::max(t, 0.0), second);
    const JointVector q = first + second;
    if (t > -h / 2) {
      const JointVector qd = (q - old) / h;
      const JointVector qdd = (q - 2 * old + older) / (h * h);
      if ((qd.array().abs() > kSlack * input.limits.speed.array()).any()) return false;
      if ((qdd.array().abs() > kSlack * input.limits.accel.array()).any()) return false;
    }
    older = old;
    old = q;
  }
  return true;
}

void MoveChain::apply_speed(double speed) {
  if (speed == speed_) return;
  speed_ = speed;
  if (running_) present_.set_speed(speed);
  if (overlaps_) next_.set_speed(speed);
}

bool MoveChain::advance(const StepInput& input, JointVector& q) {
  apply_speed(input.speed);
  if (!running_ && !waiting_.empty()) begin_next(input, q);
  if (!running_) return false;
  try_overlap(input);
  JointVector of_next;
  const bool reached = present_.advance(input.step_s, q);
  if (overlaps_) {
    // The sum of both: the next move begins at the present one's end.
    const bool both = next_.advance(input.step_s, of_next);
    q += of_next - present_.end();
    if (!reached) return true;
    ++done_;
    q = of_next;
    present_ = next_;
    rounding_ = next_rounding_;
    overlaps_ = false;
    if (!both) return true;
  } else if (!reached) {
    return true;
  }
  ++done_;
  running_ = false;
  return !waiting_.empty();
}

void MoveChain::clear() {
  running_ = overlaps_ = false;
  waiting_.clear();
}

const JointVector& MoveChain::end(const JointVector& q) const {
  if (!waiting_.empty()) return waiting_.back().target;
  if (overlaps_) return next_.end();
  return running_ ? present_.end() : q;
}

}  // namespace aprsim::robot
