#pragma once

#include <vector>

#include "world/robot/planning/motion_planner.hpp"

namespace aprsim::robot {

/// Plans a motion past waypoints: straight lines of the tool or straight ways in joint space,
/// blended where two of them meet within the waypoint's tolerance (5 mm and 0.05 rad where none is
/// set). Where a tolerance leaves no room for a blend the path stops and another one begins.
/// Thread: any.
class WaypointPlanner {
 public:
  /// The arguments must outlive the planner.
  WaypointPlanner(const MotionPlanner& planner, PlanStart start, const ToolLimitSettings& limits)
      : planner_(planner), start_(std::move(start)), limits_(limits) {}

  /// From rest, into `out`. Errors: kUnreachable with the waypoint, the joint or axis, value and
  /// limit.
  [[nodiscard]] Result<void> plan(const api::MoveThroughTo& move, MotionPlan& out) const;

 private:
  struct Line;
  struct JointSegment;

  [[nodiscard]] Result<std::vector<Line>> find_lines(const api::MoveThroughTo& move) const;
  [[nodiscard]] Result<void> plan_lines(const api::MoveThroughTo& move, MotionPlan& out) const;
  [[nodiscard]] Result<std::vector<JointSegment>> find_joint_segments(
      const api::MoveThroughTo& move) const;
  [[nodiscard]] Result<void> plan_joint_segments(const api::MoveThroughTo& move,
                                                 MotionPlan& out) const;
  [[nodiscard]] double corner_width(const Line& line, const Line& next,
                                    const api::PoseTolerance& tolerance) const;
  [[nodiscard]] double corner_width(const JointSegment& segment, const JointSegment& next,
                                    const api::PoseTolerance& tolerance) const;
  [[nodiscard]] double tolerance_use(const Eigen::Isometry3d& X_BT,
                                     const Eigen::Isometry3d& X_BT_goal,
                                     const api::PoseTolerance& tolerance) const;
  template <typename PoseAt>
  [[nodiscard]] double fit_blend(double room, const Eigen::Isometry3d& X_BT_goal,
                                 const api::PoseTolerance& tolerance, const PoseAt& pose) const;

  const MotionPlanner& planner_;
  PlanStart start_;
  const ToolLimitSettings& limits_;
};

}  // namespace aprsim::robot
