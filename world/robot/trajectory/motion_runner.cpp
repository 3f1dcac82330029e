#include "world/robot/trajectory/motion_runner.hpp"

#include <utility>

namespace aprsim::robot {

void MotionRunner::advance(const ArmGeometry& arm, double dt, bool held) {
  second_last_reference_ = last_reference_;
  last_reference_ = reference_;
  if (held) return;
  // The next motion begins where the one before has come to rest.
  if (!running_ && has_next_) {
    std::swap(motion_, next_);
    has_next_ = false;
    running_ = true;
    braking_.reset();
  }
  if (!running_) return;
  if (motion_.advance(arm, dt, reference_)) running_ = false;
}

void MotionRunner::replace(MotionSequence next, std::optional<Brake> braking) {
  motion_ = std::move(next);
  running_ = true;
  has_next_ = false;
  braking_ = braking;
}

void MotionRunner::queue(MotionSequence next) {
  next_ = std::move(next);
  has_next_ = true;
}

JointVector MotionRunner::brake(const ArmGeometry& arm, Brake how) {
  has_next_ = false;
  if (!running_) return reference_;
  // A hard stop is not softened.
  const bool already = braking_ && (*braking_ == how || *braking_ == Brake::kHard);
  if (!already) {
    motion_.brake(arm, how);
    braking_ = how;
  }
  return motion_.end();
}

void MotionRunner::set_speed(double fraction, bool next_only) {
  if (running_ && !next_only) motion_.set_speed(fraction);
  if (has_next_) next_.set_speed(fraction);
}

void MotionRunner::shift_to(const JointVector& q) {
  const JointVector shift = q - reference_;
  reference_ = q;
  last_reference_ += shift;
  second_last_reference_ += shift;
}

void MotionRunner::stand_at(const JointVector& q) {
  running_ = has_next_ = false;
  reference_ = last_reference_ = second_last_reference_ = q;
}

JointState MotionRunner::state(double dt) const {
  const JointVector qdd = (reference_ - 2 * last_reference_ + second_last_reference_) / (dt * dt);
  return {reference_, (reference_ - last_reference_) / dt + qdd * (dt / 2), qdd};
}

}  // namespace aprsim::robot
