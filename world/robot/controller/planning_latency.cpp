#include "world/robot/controller/planning_latency.hpp"

#include <cmath>

namespace aprsim::robot {

int planning_steps(const PlanningLatency& latency, double step_s, const PlannedMove& move,
                   bool search, api::PlanningMode mode) {
  // The latency is simulated time. It depends on the command only, never on the machine's speed.
  double latency_s = latency.base_s;
  if (const auto* through = std::get_if<api::MoveThroughTo>(&move)) {
    latency_s += latency.waypoint_s * static_cast<double>(through->waypoints.size());
  }
  if (std::holds_alternative<api::MoveScrew>(move)) latency_s += latency.screw_s;
  const bool checks = mode != api::PlanningMode::kDirect;
  if (checks) latency_s += latency.check_s;
  // The search that a free move makes is one for a way round.
  const auto* to = std::get_if<api::MoveTo>(&move);
  const bool free = (to && !to->straight) || std::holds_alternative<api::MoveJoints>(move);
  if (search) latency_s += checks && free ? latency.avoid_s : latency.search_s;
  return static_cast<int>(std::lround(latency_s / step_s));
}

}  // namespace aprsim::robot
