#include "server/cell_news.hpp"

#include <spdlog/fmt/fmt.h>

namespace aprsim::server {

void CellNews::forget() {
  lost_.clear();
  not_converged_ = false;
}

std::vector<NewsLine> CellNews::look(const api::Snapshot& now) {
  std::vector<NewsLine> out;
  if (now.epoch != epoch_) forget();
  epoch_ = now.epoch;
  if (now.world_stops != world_stops_) {
    // Reset since, its words are gone.
    const std::string& why = now.world_fault;
    out.push_back({true, "the simulation has stopped: " + (why.empty() ? "reset since" : why)});
  }
  world_stops_ = now.world_stops;
  lost_.resize(now.bodies.size(), false);
  for (std::size_t i = 0; i < now.bodies.size(); ++i) {
    const auto& step = now.bodies[i].lost_step;
    if (step && !lost_[i]) {
      out.push_back(
          {false, fmt::format("{} fell out of the cell in step {}; a reset brings it back",
                              now.cell->bodies[i].name, *step)});
    }
    lost_[i] = step.has_value();
  }
  const bool failed = now.solver_failures.not_converged > 0;
  if (failed && !not_converged_) {
    out.push_back({false,
                   "contacts: a step was given up short of the solution (solver_failures in "
                   "telemetry counts)"});
  }
  not_converged_ = failed;
  return out;
}

}  // namespace aprsim::server
