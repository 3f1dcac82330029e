#pragma once

#include "world/robot/controller/robot_controller.hpp"
#include "world/robot/controller/tool_limit_settings.hpp"
#include "world/robot/trajectory/motion_sequence.hpp"

namespace aprsim::robot {

/// Where a motion begins.
struct PlanStart {
  JointVector q;
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();  ///< the tool frame to move
};
/// A state in passing.
struct PassingState {
  JointVector q, qd, qdd;
};

/// Turns commands into motions of one robot. Every motion is checked as a whole before it may
/// start. Immutable. Thread: sim, between steps.
class MotionPlanner {
 public:
  /// `setup` must outlive the planner.
  explicit MotionPlanner(const ControllerSetup& setup);

  /// Motions from rest, into `out`. Errors: kInvalidArgument for a pose that is none, kUnreachable
  /// with the waypoint, the joint or axis, value and limit.
  [[nodiscard]] Result<void> plan(const api::MoveTo& move, const PlanStart& start,
                                  const ToolLimitSettings& limits, MotionSequence& out) const;
  [[nodiscard]] Result<void> plan(const api::MoveThroughTo& move, const PlanStart& start,
                                  const ToolLimitSettings& limits, MotionSequence& out) const;
  [[nodiscard]] Result<void> plan(const api::MoveScrew& screw, const PlanStart& start,
                                  const ToolLimitSettings& limits, MotionSequence& out) const;
  /// Motion of joints; `targets` holds the targets of the joints that are not named and takes those
  /// that are. Joints driven by torque stay out of it. Errors name the joint, value and limit.
  [[nodiscard]] Result<void> plan(const api::MoveJoints& move, const PlanStart& start,
                                  const ToolLimitSettings& limits, JointVector& targets,
                                  MotionSequence& out) const;

  /// Makes the joint motion that was planned into `out` begin in passing, without coming to rest
  /// first. False where that would leave the joints' ranges or torques: `out` is then as it was.
  [[nodiscard]] bool blend_from_motion(const PassingState& passing, const PlanStart& start,
                                       const ToolLimits& tool, MotionSequence& out) const;
  /// The fastest stop of all joints from any state.
  void plan_stop(const PassingState& passing, MotionSequence& out) const;
  /// From posture to posture at a moderate speed, for backing off.
  void plan_retreat(const JointVector& from, const JointVector& to, MotionSequence& out) const;

  [[nodiscard]] const JointLimits& joint_limits() const { return limits_; }

 private:
  [[nodiscard]] ArmGeometry arm() const { return {setup_.model, *setup_.ik}; }
  [[nodiscard]] Result<Eigen::Isometry3d> pose_in_base(const Pose& X_RT) const;
  [[nodiscard]] Result<JointVector> free_target(const Eigen::Isometry3d& X_BF,
                                                const JointVector& start) const;
  void plan_free(const JointVector& target, const PlanStart& start, const ToolLimits& tool,
                 MotionSequence& out) const;
  void start_joint_motion(JointMove& move, Motion& motion) const;
  /// Plans the path laid in `path` and slows it for the torques.
  [[nodiscard]] Result<void> start_path(const PathMove& move, PathMotion& path) const;
  [[nodiscard]] Result<void> plan_line(const Eigen::Isometry3d& X_BT, const PlanStart& start,
                                       const ToolLimits& tool, const ToolLimits& tool_max,
                                       MotionSequence& out) const;
  void cap_share(JointMove& move, const Eigen::Isometry3d& X_FT, const ToolLimits& tool) const;
  [[nodiscard]] Result<void> check(const api::JointTarget& target) const;
  [[nodiscard]] Result<void> check_torque(const Joint& joint, const api::JointTorque& torque) const;
  [[nodiscard]] double range_distance(const JointVector& a, const JointVector& b) const;
  [[nodiscard]] bool comfortable(const JointVector& q) const;

  [[nodiscard]] Result<void> plan_through_straight(const api::MoveThroughTo& move,
                                                   const PlanStart& start,
                                                   const ToolLimitSettings& limits,
                                                   MotionSequence& out) const;
  [[nodiscard]] Result<void> plan_through_free(const api::MoveThroughTo& move,
                                               const PlanStart& start,
                                               const ToolLimitSettings& limits,
                                               MotionSequence& out) const;
  [[nodiscard]] Result<void> plan_helix(const api::MoveScrew& screw, const PlanStart& start,
                                        const ToolLimitSettings& limits, MotionSequence& out) const;
  [[nodiscard]] std::vector<JointVector> start_postures(const Eigen::Isometry3d& X_BT,
                                                        const PlanStart& start) const;
  [[nodiscard]] double excess(const Eigen::Isometry3d& X_BT, const Eigen::Isometry3d& X_BT_goal,
                              const api::PoseTolerance& tolerance) const;
  /// The widest blend at a corner that passes `X_BT_goal` within the tolerance; `pose` gives the
  /// tool at the corner for a half width. 0 where only a stop does.
  template <typename PoseAt>
  [[nodiscard]] double fit_blend(double room, const Eigen::Isometry3d& X_BT_goal,
                                 const api::PoseTolerance& tolerance, const PoseAt& pose) const;

  const ControllerSetup& setup_;
  JointLimits limits_;
};

}  // namespace aprsim::robot
