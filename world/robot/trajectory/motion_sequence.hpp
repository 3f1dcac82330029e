#pragma once

#include <cstddef>
#include <vector>

#include "world/robot/trajectory/joint_motion.hpp"
#include "world/robot/trajectory/path_motion.hpp"

namespace aprsim::robot {

/// One motion of a robot of either kind, with the buffers of both, so that nothing is allocated
/// while a robot runs. A copyable value. Thread: sim.
class Motion {
 public:
  enum class Kind { kJoint, kPath };

  /// The motion to plan, of the kind that it then is.
  JointMotion& as_joint() {
    kind_ = Kind::kJoint;
    return joint_;
  }
  PathMotion& as_path() {
    kind_ = Kind::kPath;
    return path_;
  }
  /// The joint motion, if it is one.
  [[nodiscard]] const JointMotion* joint() const {
    return kind_ == Kind::kJoint ? &joint_ : nullptr;
  }

  /// Advances by `dt` and writes the position. True once at rest at end(), then exactly.
  bool advance(const ArmGeometry& arm, double dt, JointVector& q) {
    return kind_ == Kind::kJoint ? joint_.advance(dt, q) : path_.advance(arm, dt, q);
  }
  void brake(const ArmGeometry& arm, Brake how) {
    kind_ == Kind::kJoint ? joint_.brake(how) : path_.brake(arm, how);
  }
  /// Speed override 0..1 from now on.
  void set_speed(double fraction) {
    kind_ == Kind::kJoint ? joint_.set_speed(fraction) : path_.set_speed(fraction);
  }
  [[nodiscard]] const JointVector& end() const {
    return kind_ == Kind::kJoint ? joint_.end() : path_.end();
  }

 private:
  Kind kind_ = Kind::kJoint;
  JointMotion joint_;
  PathMotion path_;
};

/// Motions one after the other, each from rest to rest, each from the end of the one before. Keeps
/// the buffers of motions that are over. A copyable value. Thread: sim.
class MotionSequence {
 public:
  /// A sequence of up to `reserve` motions does not allocate later.
  explicit MotionSequence(std::size_t reserve) : motions_(reserve) {}

  void clear() { count_ = at_ = 0; }
  /// A further motion, to be planned from end().
  Motion& add() {
    if (count_ == motions_.size()) motions_.emplace_back();
    return motions_[count_++];
  }
  /// The running or first motion.
  [[nodiscard]] Motion& now() { return motions_[at_]; }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] const Motion& now() const { return motions_[at_]; }

  bool advance(const ArmGeometry& arm, double dt, JointVector& q) {
    if (!motions_[at_].advance(arm, dt, q)) return false;
    return ++at_ >= count_;
  }
  /// To rest on the way; later motions are dropped.
  void brake(const ArmGeometry& arm, Brake how) {
    motions_[at_].brake(arm, how);
    count_ = at_ + 1;
  }
  void set_speed(double fraction) {
    for (std::size_t i = at_; i < count_; ++i) motions_[i].set_speed(fraction);
  }
  [[nodiscard]] const JointVector& end() const { return motions_[count_ - 1].end(); }

 private:
  std::vector<Motion> motions_;
  std::size_t count_ = 0, at_ = 0;
};

}  // namespace aprsim::robot
