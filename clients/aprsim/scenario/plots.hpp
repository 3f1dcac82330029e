#pragma once

#include <string>

#include "clients/aprsim/scenario/run_result.hpp"

/// Plots of a run as SVG elements; empty where there is nothing to plot.
namespace aprsim::client {

/// Parts in kits over time, with faults as bands and submissions as lines.
[[nodiscard]] std::string progress_plot(const RunResult& run);
/// Times in which each robot moved.
[[nodiscard]] std::string activity_plot(const RunResult& run);
/// Distance of each part from its slot's centre, in the order of placing, with the median and the
/// 95th percentile.
[[nodiscard]] std::string placement_plot(const RunResult& run);

}  // namespace aprsim::client
