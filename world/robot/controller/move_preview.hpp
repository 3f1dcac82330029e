#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "world/api/values/move_preview.hpp"
#include "world/robot/controller/equipped_arm.hpp"
#include "world/robot/controller/motion_generator.hpp"
#include "world/robot/controller/planning_latency.hpp"
#include "world/robot/planning/plan_job.hpp"

namespace aprsim::robot {

/// A move that is planned and run through as the controller would, on a copy of its motion: the
/// same plan jobs, the same references bit for bit if nothing else happens meanwhile. A function of
/// what it is constructed from. Thread: any; make() once, cancel() beside it.
class MovePreview {
 public:
  /// A copy of the controller's parts, at the moment of the command.
  struct Setup {
    EquippedArm arm;
    MotionGenerator motion;
    MoveRequest request;
    PlanningLatency latency;
    api::PlanningMode mode = api::PlanningMode::kDirect;
    /// Their mode is check in mode direct, where they refuse nothing; null = nothing is regarded.
    std::shared_ptr<const Surroundings> surroundings;
  };

  explicit MovePreview(Setup setup) : setup_(std::move(setup)) {}

  /// Plans the move. All but epoch, step and time. Errors: kFailedPrecondition for a move longer
  /// than kMaxPreview_s; kUnavailable once it is cancelled.
  [[nodiscard]] Result<api::MovePreview> make();
  /// Nobody needs the result: make() may give up.
  void cancel();

 private:
  /// Plans from `motion`, which moves on by the latency; with a search where one is wanted. Null =
  /// cancelled.
  [[nodiscard]] std::shared_ptr<PlanJob> plan(MotionGenerator& motion, api::PlanningMode mode,
                                              const std::shared_ptr<const Surroundings>& around,
                                              int& delay_steps);
  [[nodiscard]] bool begin(const std::shared_ptr<PlanJob>& job);
  void write_points(const std::vector<JointVector>& postures, double interval_s,
                    api::MovePreview& out) const;
  void write_blocked(const BlockedMotion& blocked, bool with_points, api::MovePreview& out) const;

  Setup setup_;
  std::mutex mutex_;
  std::shared_ptr<PlanJob> job_;  ///< that is being made
  bool cancelled_ = false;
};

}  // namespace aprsim::robot
