#pragma once

#include "world/robot/joint_motion.hpp"
#include "world/robot/line_motion.hpp"

namespace aprsim::robot {

/// One motion of a robot of either kind. Holds the buffers of both, so that nothing is allocated
/// while a robot runs. Thread: sim.
class Motion {
 public:
  enum class Kind { kJoint, kLine };

  Motion(const ArmModel& model, const InverseKinematics& ik, const Eigen::Isometry3d& X_FT)
      : line_(model, ik, X_FT) {}

  /// The motion to plan, of the kind that it then is.
  JointMotion& as_joint() {
    kind_ = Kind::kJoint;
    return joint_;
  }
  LineMotion& as_line() {
    kind_ = Kind::kLine;
    return line_;
  }

  /// Advances by `dt` and writes the position. True once at rest at end(), then exactly.
  bool advance(double dt, JointVector& q) {
    return kind_ == Kind::kJoint ? joint_.advance(dt, q) : line_.advance(dt, q);
  }
  void brake(Brake how) { kind_ == Kind::kJoint ? joint_.brake(how) : line_.brake(how); }
  [[nodiscard]] const JointVector& end() const {
    return kind_ == Kind::kJoint ? joint_.end() : line_.end();
  }

 private:
  Kind kind_ = Kind::kJoint;
  JointMotion joint_;
  LineMotion line_;
};

}  // namespace aprsim::robot
