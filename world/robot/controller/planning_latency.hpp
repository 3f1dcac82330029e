#pragma once

#include "world/robot/planning/plan_job.hpp"

namespace aprsim::robot {

/// Simulated time from a move's command to its motion, in which it is planned.
struct PlanningLatency {
  double base_s = 0;
  double waypoint_s = 0;  ///< for each waypoint of MoveThroughTo
  double screw_s = 0;     ///< for a screw, which tries several postures
  double search_s = 0;    ///< once more for a search over all postures, where nothing else helps
  double check_s = 0;     ///< for a check against what stands around
  double avoid_s = 0;     ///< for a search for a way round
};

/// The same in steps. A function of the command alone, so that it is the same on any machine.
[[nodiscard]] int planning_steps(const PlanningLatency& latency, double step_s,
                                 const PlannedMove& move, bool search,
                                 api::PlanningMode mode = api::PlanningMode::kDirect);

}  // namespace aprsim::robot
