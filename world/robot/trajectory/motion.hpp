#pragma once

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

}  // namespace aprsim::robot
