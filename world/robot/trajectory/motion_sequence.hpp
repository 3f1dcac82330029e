#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "world/robot/trajectory/motion.hpp"

namespace aprsim::robot {

/// Motions planned to run one after the other, each from rest to rest, each from the end of the one
/// before. Thread: any, one at a time.
class MotionPlan {
 public:
  void clear() { motions_.clear(); }
  /// A further motion, to be planned from end().
  Motion& add() { return motions_.emplace_back(); }
  [[nodiscard]] bool empty() const { return motions_.empty(); }
  [[nodiscard]] std::size_t size() const { return motions_.size(); }
  [[nodiscard]] const Motion& operator[](std::size_t i) const { return motions_[i]; }
  [[nodiscard]] const JointVector& end() const { return motions_.back().end(); }
  /// Adds itself and what its motions share with others.
  void list(SharedParts& parts) const {
    parts[this] = sizeof *this + bytes_of(motions_);
    for (const Motion& motion : motions_) motion.list(parts);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [all] = self;
    io(all);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(!motions_.empty(), "a plan without motions");
    for (const Motion& motion : motions_)
      in.require(motion.is_planned(), "a motion without a plan");
  }

 private:
  std::vector<Motion> motions_;
};

/// Runs the motions of a plan, or a single one. A copyable value of a few kilobytes for any plan,
/// since copies share it. Never allocates. Thread: any, one at a time.
class MotionSequence {
 public:
  MotionSequence() = default;
  /// `plan` has at least one motion.
  explicit MotionSequence(std::shared_ptr<const MotionPlan> plan)
      : plan_(std::move(plan)), left_(plan_->size() - 1), motion_((*plan_)[0]) {}
  explicit MotionSequence(const JointMotion& motion) : motion_(motion) {}

  bool advance(const ArmGeometry& arm, double dt, JointVector& q) {
    if (!motion_.advance(arm, dt, q)) return false;
    if (left_ == 0) return true;
    motion_ = (*plan_)[plan_->size() - left_--];
    motion_.set_speed(speed_);
    return false;
  }
  /// To rest on the way; later motions are dropped.
  void brake(const ArmGeometry& arm, Brake how) {
    motion_.brake(arm, how);
    left_ = 0;
  }
  /// Adds positions on the way that is left, `count` for each motion.
  void remaining(std::size_t count, std::vector<JointVector>& out) const {
    motion_.remaining(count, out);
    for (std::size_t i = left_; i > 0; --i) (*plan_)[plan_->size() - i].remaining(count, out);
  }
  /// Speed override 0..1 of this and all later motions from now on.
  void set_speed(double fraction) {
    speed_ = fraction;
    motion_.set_speed(fraction);
  }
  [[nodiscard]] const JointVector& end() const { return left_ > 0 ? plan_->end() : motion_.end(); }
  [[nodiscard]] bool is_planned() const { return motion_.is_planned(); }
  /// Adds what copies share.
  void list(SharedParts& parts) const {
    if (plan_) plan_->list(parts);
    motion_.list(parts);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [plan, left, speed, motion] = self;
    io(plan, left, speed, motion);
    io.require(left == 0 || (plan && left < plan->size()), "more motions left than are planned");
  }

 private:
  std::shared_ptr<const MotionPlan> plan_;
  std::size_t left_ = 0;  ///< motions after the present one
  double speed_ = 1;
  Motion motion_;  ///< the running or first one
};

}  // namespace aprsim::robot
