#include "world/robot/controller/planning_latency.hpp"

#include <cmath>

namespace aprsim::robot {

int planning_steps(const PlanningLatency& latency, double step_s, const PlannedMove& move,
                   bool search) {
  // The latency is simulated time. It depends on the command only, never on the machine's speed.
  double latency_s = latency.base_s;
  if (const auto* through = std::get_if<api::MoveThroughTo>(&move)) {
    latency_s += latency.waypoint_s * static_cast<double>(through->waypoints.size());
  }
  if (std::holds_alternative<api::MoveScrew>(move)) latency_s += latency.screw_s;
  if (search) latency_s += latency.search_s;
  return static_cast<int>(std::lround(latency_s / step_s));
}

}  // namespace aprsim::robot
