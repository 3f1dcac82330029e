#pragma once

#include "world/api/command.hpp"
#include "world/robot/motion.hpp"
#include "world/robot/robot_controller.hpp"

namespace aprsim::robot {

/// Turns commands into motions of one robot, each from rest at a given posture. Every motion is
/// checked as a whole before it may start. Thread: sim, between steps.
class MotionPlanner {
 public:
  /// `setup` must outlive the planner.
  explicit MotionPlanner(const ControllerSetup& setup);

  /// Free or straight motion of the tool to a pose. Errors: kInvalidArgument for a pose that is
  /// none, kUnreachable with the joint or axis, value and limit.
  [[nodiscard]] Result<void> plan(const api::MoveTo& move, const JointVector& start,
                                  const ToolLimits& tool, const ToolLimits& tool_max,
                                  Motion& motion) const;
  /// Motion of joints; `targets` holds the targets of the joints that are not named and takes those
  /// that are. Errors name the joint, the value and its limit.
  [[nodiscard]] Result<void> plan(const api::MoveJoints& move, const JointVector& start,
                                  const ToolLimits& tool_max, JointVector& targets,
                                  Motion& motion) const;
  /// The fastest stop of all joints from any state.
  void plan_stop(const JointVector& q, const JointVector& qd, const JointVector& qdd,
                 Motion& motion) const;

  [[nodiscard]] const JointLimits& joint_limits() const { return limits_; }

 private:
  [[nodiscard]] Result<JointVector> free_target(const Eigen::Isometry3d& X_BF,
                                                const JointVector& start) const;
  [[nodiscard]] Result<void> plan_line(const Eigen::Isometry3d& X_BT, const JointVector& start,
                                       const ToolLimits& tool, const ToolLimits& tool_max,
                                       Motion& motion) const;
  void start_joint_motion(JointMove& move, Motion& motion) const;
  void cap_share(JointMove& move, const ToolLimits& tool) const;
  [[nodiscard]] Result<void> check(const api::JointTarget& target) const;
  [[nodiscard]] double range_distance(const JointVector& a, const JointVector& b) const;
  [[nodiscard]] bool comfortable(const JointVector& q) const;

  const ControllerSetup& setup_;
  JointLimits limits_;
};

}  // namespace aprsim::robot
