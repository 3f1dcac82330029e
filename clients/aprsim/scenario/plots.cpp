#include "clients/aprsim/scenario/plots.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace aprsim::client {
namespace {

constexpr double kWidth = 860, kLeft = 60, kRight = 15, kTop = 10, kBottom = 36;
constexpr double kTitle = 18;  // height of a line over the frame
constexpr const char* kBlue = "#2767a8";

/// 1, 2 or 5 times a power of ten, so that some five of them make the span.
double tick_of(double span) {
  const double raw = std::max(span, 1e-9) / 5;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power) return factor * power;
  }
  return 10 * power;
}

/// A frame with both axes from zero.
class Frame {
 public:
  Frame(double height, double max_x, double max_y, const char* x_title, const char* y_title)
      : height_(height),
        top_(kTop + (*y_title == '\0' ? 0 : kTitle)),
        max_x_(std::max(max_x, 1e-9)),
        max_y_(std::max(max_y, 1e-9)) {
    out_ = fmt::format(
        "<svg viewBox=\"0 0 {} {}\" role=\"img\" font-family=\"sans-serif\" font-size=\"12\">\n",
        kWidth, height_);
    const double tick_x = tick_of(max_x_);
    for (int i = 0; i * tick_x <= max_x_ * 1.0001; ++i) {
      out_ += fmt::format(
          "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\" stroke=\"#d5dbe0\"/><text "
          "x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">{4:g}</text>\n",
          x(i * tick_x), top_, height_ - kBottom, height_ - kBottom + 15, i * tick_x);
    }
    out_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>\n", kWidth - kRight,
                        height_ - 5, x_title);
    if (*y_title == '\0') return;
    const double tick_y = tick_of(max_y_);
    for (int i = 0; i * tick_y <= max_y_ * 1.0001; ++i) {
      out_ += fmt::format(
          "<line x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"#d5dbe0\"/><text "
          "x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n",
          kLeft, kWidth - kRight, y(i * tick_y), kLeft - 6, y(i * tick_y) + 4, i * tick_y);
    }
    out_ += fmt::format("<text x=\"4\" y=\"{}\">{}</text>\n", kTop + 4, y_title);
  }

  [[nodiscard]] double x(double value) const {
    return kLeft + value / max_x_ * (kWidth - kLeft - kRight);
  }
  [[nodiscard]] double y(double value) const {
    return height_ - kBottom - value / max_y_ * (height_ - kBottom - top_);
  }

  void band(double from_x, double to_x, double from_y, double to_y, const char* colour,
            double opacity, const std::string& title) {
    out_ += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\" "
        "fill-opacity=\"{}\"><title>{}</title></rect>\n",
        x(from_x), y(to_y), std::max(1.0, x(to_x) - x(from_x)), y(from_y) - y(to_y), colour,
        opacity, title);
  }
  void line(double at_x, const char* colour, const std::string& title) {
    out_ += fmt::format(
        "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\" stroke=\"{3}\" "
        "stroke-dasharray=\"4 3\"><title>{4}</title></line>\n",
        x(at_x), top_, height_ - kBottom, colour, title);
  }
  void dot(double at_x, double at_y, const std::string& title) {
    out_ += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"><title>{}</title></circle>\n",
        x(at_x), y(at_y), kBlue, title);
  }
  void add(const std::string& element) { out_ += element; }
  [[nodiscard]] std::string text() const { return out_ + "</svg>\n"; }

 private:
  double height_, top_, max_x_, max_y_;
  std::string out_;
};

}  // namespace

std::string progress_plot(const RunResult& run) {
  const Measured& measured = run.measured;
  const auto parts = static_cast<double>(measured.placements.size());
  Frame frame(260, measured.end_s, parts + 1, "time [s]", "parts in kits");
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
  frame.add(fmt::format(
      "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"2\" points=\"{}\"/>\n", kBlue, points));
  return frame.text();
}

std::string activity_plot(const RunResult& run) {
  const Measured& measured = run.measured;
  const auto rows = static_cast<double>(measured.robots.size());
  Frame frame(kTop + kBottom + 30 * rows, measured.end_s, rows, "time [s]", "");
  double row = rows;
  for (const RobotResult& robot : measured.robots) {
    row -= 1;
    for (const auto& [from_s, to_s] : robot.moving) {
      frame.band(from_s, to_s, row + 0.2, row + 0.8, kBlue, 0.8,
                 fmt::format("{} moves, {:.1f} to {:.1f} s", robot.name, from_s, to_s));
    }
    frame.add(
        fmt::format("<text x=\"4\" y=\"{:.1f}\">{}</text>\n", frame.y(row + 0.5) + 4, robot.name));
  }
  return frame.text();
}

std::string placement_plot(const RunResult& run) {
  const auto& placements = run.measured.placements;
  double worst_mm = 0.1;
  for (const Placement& placement : placements) {
    worst_mm = std::max(worst_mm, 1e3 * placement.error_m);
  }
  Frame frame(220, static_cast<double>(placements.size()) + 1, worst_mm * 1.1, "part",
              "error [mm]");
  double index = 0;
  for (const Placement& placement : placements) {
    index += 1;
    frame.dot(index, 1e3 * placement.error_m,
              fmt::format("{} in {}, by {}: {:.3f} mm", placement.gear, placement.slot,
                          placement.robot, 1e3 * placement.error_m));
  }
  return frame.text();
}

}  // namespace aprsim::client
