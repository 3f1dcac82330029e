#pragma once

#include <vector>

#include "world/robot/planning/motion_planner.hpp"

namespace aprsim::robot {

/// Plans a screw motion: a free move to its start pose, if there is one, a free advance along the
/// tool's axis, then a helix. Thread: any.
class ScrewPlanner {
 public:
  /// The arguments must outlive the planner.
  ScrewPlanner(const MotionPlanner& planner, PlanStart start, const ToolLimitSettings& limits)
      : planner_(planner), start_(std::move(start)), limits_(limits) {}

  /// From rest, into `out`. Errors: kUnreachable with the joint or axis, value and limit.
  [[nodiscard]] Result<void> plan(const api::MoveScrew& screw, MotionPlan& out) const;

 private:
  [[nodiscard]] Result<void> add_screw(const api::MoveScrew& screw, const JointVector& start,
                                       MotionPlan& out) const;
  [[nodiscard]] std::vector<JointVector> start_postures(const Eigen::Isometry3d& X_BT) const;

  const MotionPlanner& planner_;
  PlanStart start_;
  const ToolLimitSettings& limits_;
};

}  // namespace aprsim::robot
