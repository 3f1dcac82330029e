#include "tests/benchmarks/heap/convergence.hpp"

#include "tests/benchmarks/support/statistics.hpp"

namespace aprsim::bench {

Convergence::Iteration& Convergence::at(std::size_t iteration) {
  if (iterations_.size() <= iteration) iterations_.resize(iteration + 1);
  return iterations_[iteration];
}

void Convergence::add(const physics::ContactSolverStatistics& statistics) {
  const auto outer = statistics.outer_iterations();
  if (outer.empty()) return;
  std::vector<double> residuals_m_s = {statistics.start_residual_m_s};
  at(0).residuals_m_s.push_back(statistics.start_residual_m_s);
  for (std::size_t i = 0; i < outer.size(); ++i) {
    Iteration& iteration = at(i + 1);
    iteration.residuals_m_s.push_back(outer[i].residual_m_s);
    iteration.proximal_weights.push_back(outer[i].proximal_weight);
    iteration.newton_steps.push_back(outer[i].newton_steps);
    iteration.rejected += !outer[i].accepted;
    residuals_m_s.push_back(outer[i].residual_m_s);
  }
  if (residuals_m_s.size() > longest_m_s_.size()) longest_m_s_ = residuals_m_s;
}

Table Convergence::table() const {
  Table out({"iteration", "solves", "rejected", "residual: median [m/s]", "90 % [m/s]",
             "largest [m/s]", "longest solve [m/s]", "proximal weight: median",
             "Newton steps: mean"});
  for (std::size_t i = 0; i < iterations_.size(); ++i) {
    const Iteration& all = iterations_[i];
    out.row({double(i), double(all.residuals_m_s.size()), double(all.rejected),
             percentile(all.residuals_m_s, 0.5), percentile(all.residuals_m_s, 0.9),
             percentile(all.residuals_m_s, 1), longest_m_s_[i],
             all.proximal_weights.empty() ? 0 : median(all.proximal_weights),
             all.newton_steps.empty() ? 0 : mean(all.newton_steps)});
  }
  return out;
}

Plot Convergence::plot() const {
  Series half{"median", {}}, most{"90 %", {}}, longest{"longest solve", {}};
  for (std::size_t i = 0; i < iterations_.size(); ++i) {
    const auto& residuals_m_s = iterations_[i].residuals_m_s;
    half.points.emplace_back(double(i), percentile(residuals_m_s, 0.5));
    most.points.emplace_back(double(i), percentile(residuals_m_s, 0.9));
    longest.points.emplace_back(double(i), longest_m_s_[i]);
  }
  return {.title = "Residual over the outer iterations of the contact solver",
          .x = {.label = "outer iteration"},
          .y = {.label = "residual [m/s]", .log = true, .floor = 1e-12},
          .series = {half, most, longest}};
}

}  // namespace aprsim::bench
