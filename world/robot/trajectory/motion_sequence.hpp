#pragma once

#include <cstddef>
#include <vector>

#include "world/robot/trajectory/motion.hpp"

namespace aprsim::robot {

/// Motions one after the other, each from rest to rest, each from the end of the one before. Keeps
/// the buffers of motions that are over. A copyable value. Thread: sim.
class MotionSequence {
 public:
  /// A sequence of up to `reserve` motions does not allocate later.
  explicit MotionSequence(std::size_t reserve) : motions_(reserve) {}

  void clear() { count_ = current_ = 0; }
  /// A further motion, to be planned from end().
  Motion& add() {
    if (count_ == motions_.size()) motions_.emplace_back();
    return motions_[count_++];
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  /// The running or first motion.
  [[nodiscard]] Motion& current() { return motions_[current_]; }

  bool advance(const ArmGeometry& arm, double dt, JointVector& q) {
    if (!motions_[current_].advance(arm, dt, q)) return false;
    return ++current_ >= count_;
  }
  /// To rest on the way; later motions are dropped.
  void brake(const ArmGeometry& arm, Brake how) {
    motions_[current_].brake(arm, how);
    count_ = current_ + 1;
  }
  void set_speed(double fraction) {
    for (std::size_t i = current_; i < count_; ++i) motions_[i].set_speed(fraction);
  }
  [[nodiscard]] const JointVector& end() const { return motions_[count_ - 1].end(); }

 private:
  std::vector<Motion> motions_;
  std::size_t count_ = 0, current_ = 0;
};

}  // namespace aprsim::robot
