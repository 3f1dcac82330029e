#include "server/cell_news.hpp"

#include <spdlog/fmt/fmt.h>

namespace aprsim::server {

void CellNews::forget() {
  lost_.clear();
  estimated_ = not_converged_ = fallback_ = oversized_ = false;
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
  const api::SolverFailures& failures = now.solver_failures;
  tell_once(failures.estimated > 0, estimated_,
            "contacts: friction of a grip was estimated, not solved exactly", out);
  tell_once(failures.not_converged > 0, not_converged_,
            "contacts: the solution of a grip was given up", out);
  tell_once(failures.fallbacks > 0, fallback_,
            "contacts: the direct solver broke down, the iterative one took over", out);
  tell_once(failures.oversized > 0, oversized_,
            "contacts: a grip has more than the exact solver takes, the iterative one took over",
            out);
  return out;
}

void CellNews::tell_once(bool happened, bool& told, const char* text, std::vector<NewsLine>& out) {
  if (happened && !told) {
    out.push_back({false, std::string(text) + " (solver_failures in telemetry counts)"});
  }
  told = happened;
}

}  // namespace aprsim::server
