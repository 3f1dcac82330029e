#include "clients/aprsim/scenario/plots.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "clients/aprsim/scenario/plot_frame.hpp"

namespace aprsim::client {

std::string progress_plot(const RunResult& run) {
  const Measured& measured = run.measured;
  if (measured.kits.empty() && measured.placements.empty()) return "";
  const auto parts = static_cast<double>(measured.placements.size());
  PlotFrame frame(260, measured.end_s, parts + 1, "time [s]", "parts in kits");
  for (const FaultResult& fault : measured.faults) {
    frame.band(fault.begin_s, fault.end_s.value_or(measured.end_s), 0, parts + 1, "#c9372c", 0.15,
               fault.kind + ' ' + fault.target);
  }
  for (const KitResult& kit : measured.kits) {
    if (kit.submitted_s) frame.line(*kit.submitted_s, "#187a3d", "submitted: " + kit.order);
  }
  std::string points = fmt::format("{:.1f},{:.1f}", frame.x(0), frame.y(0));
  double count = 0;
  for (const Placement& placement : measured.placements) {
    points += fmt::format(" {0:.1f},{1:.1f} {0:.1f},{2:.1f}", frame.x(placement.time_s),
                          frame.y(count), frame.y(count + 1));
    ++count;
  }
  points += fmt::format(" {:.1f},{:.1f}", frame.x(measured.end_s), frame.y(count));
  frame.add(
      fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"2\" points=\"{}\"/>\n",
                  PlotFrame::kBlue, points));
  return frame.text();
}

std::string activity_plot(const RunResult& run) {
  const Measured& measured = run.measured;
  if (measured.robots.empty()) return "";
  const auto rows = static_cast<double>(measured.robots.size());
  PlotFrame frame(PlotFrame::kTop + PlotFrame::kBottom + 30 * rows, measured.end_s, rows,
                  "time [s]", "");
  double row = rows;
  for (const RobotResult& robot : measured.robots) {
    row -= 1;
    for (const auto& [from_s, to_s] : robot.moving) {
      frame.band(from_s, to_s, row + 0.2, row + 0.8, PlotFrame::kBlue, 0.8,
                 fmt::format("{} moves, {:.1f} to {:.1f} s", robot.name, from_s, to_s));
    }
    frame.add(fmt::format("<text x=\"4\" y=\"{:.1f}\">{}</text>\n", frame.y(row + 0.5) + 4,
                          escaped_html(robot.name)));
  }
  return frame.text();
}

std::string placement_plot(const RunResult& run) {
  const auto& placements = run.measured.placements;
  if (placements.empty()) return "";
  double worst_mm = 0.1;
  for (const Placement& placement : placements) {
    worst_mm = std::max(worst_mm, 1e3 * placement.error_m);
  }
  PlotFrame frame(220, static_cast<double>(placements.size()) + 1, worst_mm * 1.1, "part",
                  "error [mm]");
  double index = 0;
  for (const Placement& placement : placements) {
    index += 1;
    frame.dot(index, 1e3 * placement.error_m,
              fmt::format("{} in {}, by {}: {:.3f} mm", placement.gear, placement.slot,
                          placement.robot, 1e3 * placement.error_m));
  }
  for (const char* measure : {"placement_p50_mm", "placement_p95_mm"}) {
    const auto value = run.measured.values.find(measure);
    if (value != run.measured.values.end()) {
      frame.level(value->second, fmt::format("{} {:.3f} mm", measure, value->second));
    }
  }
  return frame.text();
}

}  // namespace aprsim::client
