#pragma once

#include <optional>
#include <utility>

#include "world/robot/trajectory/joint_state.hpp"
#include "world/robot/trajectory/motion_sequence.hpp"

namespace aprsim::robot {

/// Gives the reference of each step: runs one motion, and the next one where that has come to rest.
/// A copyable value, cheap to copy: advancing a copy predicts where the robot will be. Never
/// allocates. Thread: any, one at a time.
class MotionRunner {
 public:
  explicit MotionRunner(const JointVector& q)
      : reference_(q), last_reference_(q), second_last_reference_(q) {}

  /// One step. `held`: the brakes hold the arm, the reference rests.
  void advance(const ArmGeometry& arm, double dt, bool held);

  /// The running motion ends here at once; `next` runs from the next step on. `braking`: it is a
  /// stop of that kind.
  void replace(MotionSequence next, std::optional<Brake> braking = {});
  /// `next` runs where the running motion comes to rest.
  void queue(MotionSequence next);
  /// Brakes the running motion and drops the next one; returns the posture of rest.
  JointVector brake(const ArmGeometry& arm, Brake how);
  void drop_next() { has_next_ = false; }
  /// Speed override of the next motion and, unless `next_only`, of the running one.
  void set_speed(double fraction, bool next_only);

  /// The reference is `q` from now on, at the velocity that it has.
  void shift_to(const JointVector& q);
  /// Sets the reference to `q`, at rest, and drops all motions.
  void set_at_rest(const JointVector& q);

  [[nodiscard]] const JointVector& reference() const { return reference_; }
  /// Writable for joints in torque mode.
  [[nodiscard]] JointVector& reference() { return reference_; }
  [[nodiscard]] const JointVector& last_reference() const { return last_reference_; }
  /// Backward differences; the velocity is extrapolated by half a step to the reference itself.
  [[nodiscard]] JointState state(double dt) const;
  [[nodiscard]] bool running() const { return running_; }
  [[nodiscard]] bool idle() const { return !running_ && !has_next_; }
  /// Adds what copies share: the plans of the motions.
  void list(SharedParts& parts) const {
    motion_.list(parts);
    next_.list(parts);
  }
  /// Where the last of the motions ends; only while not idle.
  [[nodiscard]] const JointVector& end() const { return has_next_ ? next_.end() : motion_.end(); }

  /// Adds the reference and positions on the way that is left, `count` for each motion.
  void remaining(std::size_t count, std::vector<JointVector>& out) const {
    out.push_back(reference_);
    if (running_) motion_.remaining(count, out);
    if (has_next_) next_.remaining(count, out);
  }

  static MotionRunner blank() { return MotionRunner(JointVector()); }
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [motion, next, running, has_next, braking, reference, last_reference,
           second_last_reference] = self;
    io(motion, next, running, has_next, braking, reference, last_reference, second_last_reference);
  }
  template <typename In>
  void require_valid(In& in) const {
    for (const JointVector* each : {&reference_, &last_reference_, &second_last_reference_}) {
      in.all_joints(each->size());
    }
    in.require((!running_ || motion_.is_planned()) && (!has_next_ || next_.is_planned()),
               "a motion that is not planned");
  }

 private:
  MotionSequence motion_, next_;
  bool running_ = false, has_next_ = false;
  std::optional<Brake> braking_;
  JointVector reference_, last_reference_, second_last_reference_;
};

inline void MotionRunner::advance(const ArmGeometry& arm, double dt, bool held) {
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

inline void MotionRunner::replace(MotionSequence next, std::optional<Brake> braking) {
  motion_ = std::move(next);
  running_ = true;
  has_next_ = false;
  braking_ = braking;
}

inline void MotionRunner::queue(MotionSequence next) {
  next_ = std::move(next);
  has_next_ = true;
}

inline JointVector MotionRunner::brake(const ArmGeometry& arm, Brake how) {
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

inline void MotionRunner::set_speed(double fraction, bool next_only) {
  if (running_ && !next_only) motion_.set_speed(fraction);
  if (has_next_) next_.set_speed(fraction);
}

inline void MotionRunner::shift_to(const JointVector& q) {
  const JointVector shift = q - reference_;
  reference_ = q;
  last_reference_ += shift;
  second_last_reference_ += shift;
}

inline void MotionRunner::set_at_rest(const JointVector& q) {
  running_ = has_next_ = false;
  reference_ = last_reference_ = second_last_reference_ = q;
}

inline JointState MotionRunner::state(double dt) const {
  const JointVector qdd = (reference_ - 2 * last_reference_ + second_last_reference_) / (dt * dt);
  return {reference_, (reference_ - last_reference_) / dt + qdd * (dt / 2), qdd};
}

}  // namespace aprsim::robot
