#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

#include "world/robot/planning/plan_job.hpp"

namespace aprsim::robot {

/// Moves that have no motion yet: the one being planned, and the latest that came meanwhile. A move
/// that waits is replaced by a newer one. A copyable value; copies share the job and read its
/// request only. Thread: sim.
class PlanQueue {
 public:
  /// Begins a plan in place of everything before. `prefetcher`, if any, makes it ahead.
  void begin(std::shared_ptr<PlanJob> job, PlanPrefetcher* prefetcher);
  /// Drops all moves; the plan that is being made is given up.
  void cancel();
  /// Whether a move with this latency waits for the present plan. A plan that is nearly ready is
  /// waited for, so that moves in quick succession do move the arm. A longer one is given up,
  /// except a search: the new move may need one as well.
  [[nodiscard]] bool waits(int latency_steps) const;
  /// The move is planned after the present one, in place of one that waits already.
  void wait(MoveRequest request) { waiting_ = std::move(request); }

  /// One step; returns whether the planned motion is due in it.
  bool step() { return job_ && steps_left_-- == 0; }
  /// The plan that is due.
  [[nodiscard]] std::shared_ptr<PlanJob> take() { return std::exchange(job_, nullptr); }
  /// The move that waits, if any.
  [[nodiscard]] std::optional<MoveRequest> take_waiting() {
    return std::exchange(waiting_, std::nullopt);
  }

  [[nodiscard]] bool planning() const { return job_ != nullptr; }

  /// A copy without the plan that is being made: only the request is kept. Allocates.
  [[nodiscard]] PlanQueue unmade() const;
  /// Plans the restored request again: other copies may cancel the shared job. Allocates.
  void replan(const MotionPlanner& planner, PlanPrefetcher* prefetcher);

  /// Memory besides the value itself and what copies share, approximately.
  [[nodiscard]] std::size_t bytes() const;
  /// Adds what copies share: the plans of motions.
  void list(SharedParts& parts) const {
    if (job_) job_->request().runner.list(parts);
  }

  /// See world/archive/archive.hpp. The request of what is being planned.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [job, steps_left, waiting] = self;
    io(job, steps_left, waiting);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(!job_ || (steps_left_ >= 0 && steps_left_ <= kMaxPlanSteps),
               "a plan that is due too late");
  }

 private:
  std::shared_ptr<PlanJob> job_;  ///< null = none
  int steps_left_ = 0;            ///< until its motion begins
  std::optional<MoveRequest> waiting_;
};

}  // namespace aprsim::robot
