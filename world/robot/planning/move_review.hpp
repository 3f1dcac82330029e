#pragma once

#include <memory>
#include <vector>

#include "world/robot/avoidance/collision_checker.hpp"
#include "world/robot/planning/blocked_motion.hpp"
#include "world/robot/planning/motion_planner.hpp"

namespace aprsim::robot {

/// A planned move as it is to be reviewed.
struct ReviewedMove {
  PlanStart start;
  const api::MoveTo* free_pose = nullptr;  ///< of a free move of the tool; else null
  bool is_free = false;                    ///< only its end matters: it may go another way
  ToolLimits tool, maximum;                ///< of the tool's motion, as set and at most
};

/// Reviews the planned motions of one move against what stands around the arm: they pass, or are
/// replaced by others that go round, or are refused. Thread: one at a time.
class MoveReview {
 public:
  /// The arguments must outlive it.
  MoveReview(const MotionPlanner& planner, const Surroundings& around, ReviewedMove move);

  /// Reviews `motions`, all from rest to rest. `search`: a way round is searched where one is
  /// needed; else `search_wanted` is set there. Errors: kFailedPrecondition, what touches what,
  /// where and when.
  [[nodiscard]] Result<void> run(MotionPlan& motions, bool search, bool& search_wanted);
  /// Whether a motion that leads to the same end in another way touches nothing.
  [[nodiscard]] bool allows(const JointMotion& motion);
  /// The first motion that was found to touch something; null = none was.
  [[nodiscard]] const std::shared_ptr<const BlockedMotion>& blocked() const { return blocked_; }
  /// Positions of the tool point in R along the reviewed motions [m].
  [[nodiscard]] std::shared_ptr<const std::vector<Eigen::Vector3d>> path(
      const MotionPlan& motions) const;

 private:
  [[nodiscard]] std::vector<JointVector> other_targets(const JointVector& first) const;
  [[nodiscard]] Result<void> check_ends(const MotionPlan& motions);
  [[nodiscard]] Result<void> check(const MotionPlan& motions);
  void keep_blocked(const Touch& touch, double interval_s, std::vector<JointVector> postures);
  [[nodiscard]] Result<void> go_round(const JointMotion& direct, MotionPlan& motions);
  [[nodiscard]] bool lead_along(const std::vector<JointVector>& postures, const JointMove& like,
                                MotionPlan& out);
  [[nodiscard]] bool plan_along(const std::vector<JointVector>& postures, const JointMove& like,
                                double blend, MotionPlan& out) const;

  const MotionPlanner& planner_;
  ReviewedMove move_;
  CollisionChecker checker_;
  std::shared_ptr<const BlockedMotion> blocked_;
};

}  // namespace aprsim::robot
