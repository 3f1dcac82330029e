#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "world/api/commands/robot_command.hpp"
#include "world/base/result.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/kinematics/inverse_kinematics.hpp"
#include "world/robot/trajectory/limits/tool_limits.hpp"
#include "world/robot/trajectory/motion_runner.hpp"
#include "world/robot/trajectory/profile/joint_limits.hpp"

namespace aprsim::robot {

/// The arm that motions are planned for; SI.
struct PlannerSetup {
  ArmModel model;
  std::shared_ptr<const InverseKinematics> ik;
  Eigen::Isometry3d X_BR = Eigen::Isometry3d::Identity();
  Payload payload;
  Eigen::Vector3d gravity_B{0, 0, -9.81};
};

/// Where a motion begins.
struct PlanStart {
  JointVector q;
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();  ///< the tool frame to move
};

/// Where `target` leads its joint, with the shares of what `held` holds [rad].
[[nodiscard]] double position_of(const api::JointTarget& target, const JointVector& held);

/// The time scale of a planned motion with which no drive needs more than kTorqueShare of its
/// maximal torque: the factor on its speeds (its square on the accelerations), 1 where it need not
/// be slowed. `position` gives the joints at a time in 0..duration, and is sampled at fixed shares
/// of the duration. Thread: any.
[[nodiscard]] double torque_scaling(const ArmModel& model, const Payload& payload,
                                    const Eigen::Vector3d& gravity_B, double duration_s,
                                    const std::function<JointVector(double)>& position);

/// Plans the motions of one robot that have one target, and the segments of which the other
/// planners compose theirs. Every motion is checked as a whole before it may start; indices and
/// numbers have been checked before (world/cell/commands/command_check.hpp). Immutable; copies
/// share the arm. Thread: any.
class MotionPlanner {
 public:
  explicit MotionPlanner(PlannerSetup setup);
  /// The same planner, which gives up soon after `cancelled` has become true: with kUnavailable, or
  /// with a plan of no use. The flag must outlive it.
  [[nodiscard]] MotionPlanner until(const std::atomic<bool>& cancelled) const;
  [[nodiscard]] bool cancelled() const { return arm().cancelled(); }
  /// The same planner, which makes no search over all postures of a redundant arm, but sets
  /// `wanted` where one would help. The flag must outlive it.
  [[nodiscard]] MotionPlanner without_search(bool& wanted) const;

  // ---- whole motions from rest

  /// Into `out`. Errors: kUnreachable with the joint or axis, value and limit.
  [[nodiscard]] Result<void> plan(const api::MoveTo& move, const PlanStart& start,
                                  const ToolLimitSettings& limits, MotionPlan& out) const;
  /// Motion of joints; `targets` holds the targets of the joints that are not named and receives
  /// those that are. Joints in torque mode stay out of it. Errors name the joint, value and limit.
  [[nodiscard]] Result<void> plan(const api::MoveJoints& move, const PlanStart& start,
                                  const ToolLimitSettings& limits, JointVector& targets,
                                  MotionPlan& out) const;

  // ---- motions from a moving arm

  /// The joint motion that was planned from rest, but beginning from `state` without coming to rest
  /// first. None where that would leave the joints' ranges or torques.
  [[nodiscard]] std::optional<JointMotion> blend_from_motion(const JointState& state,
                                                             const Eigen::Isometry3d& X_FT,
                                                             const ToolLimits& tool,
                                                             const ToolLimits& maximum,
                                                             const JointMotion& from_rest) const;
  /// The fastest stop of all joints from any state.
  [[nodiscard]] JointMotion plan_stop(const JointState& state) const;
  /// From posture to posture at a moderate speed.
  [[nodiscard]] JointMotion plan_retreat(const JointVector& from, const JointVector& to) const;

  // ---- segments, added to `out`

  [[nodiscard]] Eigen::Isometry3d pose_in_base(const Pose& X_RT) const;
  /// The posture for a pose that is nearest to `start`; a redundant arm keeps its elbow angle where
  /// that costs little more joint motion.
  [[nodiscard]] Result<JointVector> target_posture(const Eigen::Isometry3d& X_BF,
                                                   const JointVector& start) const;
  /// All joints together to a posture.
  void add_joint_motion(const JointVector& target, const PlanStart& start, const ToolLimits& tool,
                        const ToolLimits& maximum, MotionPlan& out) const;
  /// A straight line of the tool; of two ways round for a half turn either that is possible.
  [[nodiscard]] Result<void> add_line(const Eigen::Isometry3d& X_BT, const PlanStart& start,
                                      const ToolLimits& tool, const ToolLimits& tool_maximum,
                                      MotionPlan& out) const;
  /// Plans the path that `path` holds, slowed for the drives' torques.
  [[nodiscard]] Result<void> plan_path(const PathMove& move, PathMotion& path) const;
  /// Limits the rate and acceleration of the shared profile: the tool's point keeps its limits
  /// along the way, and the tool turns from the first to the last orientation no faster than its
  /// limits. In between a wrist that unwinds may turn it faster, up to `maximum`.
  void limit_tool_rates(JointMove& move, const Eigen::Isometry3d& X_FT, const ToolLimits& tool,
                        const ToolLimits& maximum) const;

  /// In shares of the joint ranges.
  [[nodiscard]] double range_distance(const JointVector& a, const JointVector& b) const;
  [[nodiscard]] const JointLimits& joint_limits() const { return limits_; }
  [[nodiscard]] ArmGeometry arm() const {
    return {setup_->model, *setup_->ik, cancelled_, search_wanted_};
  }
  [[nodiscard]] const Payload& payload() const { return setup_->payload; }
  [[nodiscard]] const Eigen::Isometry3d& X_BR() const { return setup_->X_BR; }
  [[nodiscard]] Eigen::Isometry3d tool_pose(const JointVector& q,
                                            const Eigen::Isometry3d& X_FT) const;

 private:
  void plan_joint_motion(JointMove& move, JointMotion& motion) const;
  [[nodiscard]] double scale_for_torques(const JointMotion& motion) const;
  [[nodiscard]] bool clear_of_limits(const JointVector& q) const;

  std::shared_ptr<const PlannerSetup> setup_;
  JointLimits limits_;
  const std::atomic<bool>* cancelled_ = nullptr;
  bool* search_wanted_ = nullptr;
};

}  // namespace aprsim::robot
