#include "clients/aprsim/scenario/plot_frame.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace aprsim::client {
namespace {

constexpr double kTitle = 18;  // height of a line over the frame

/// 1, 2 or 5 times a power of ten, so that some five of them make the span.
double tick_of(double span) {
  const double raw = std::max(span, 1e-9) / 5;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power) return factor * power;
  }
  return 10 * power;
}

PlotFrame::Axis wide_enough(PlotFrame::Axis axis) {
  axis.max = std::max(axis.max, axis.min + 1e-9);
  return axis;
}

/// Calls `mark` with each tick of an axis.
template <typename Mark>
void for_ticks(const PlotFrame::Axis& axis, const Mark& mark) {
  const double tick = tick_of(axis.max - axis.min);
  const double slack = 1e-4 * (axis.max - axis.min);
  for (double i = std::ceil((axis.min - slack) / tick); i * tick <= axis.max + slack; i += 1) {
    mark(i == 0 ? 0.0 : i * tick);
  }
}

}  // namespace

PlotFrame::PlotFrame(double height, Axis x_axis, Axis y_axis)
    : height_(height),
      top_(kTop + (y_axis.title.empty() ? 0 : kTitle)),
      x_(wide_enough(std::move(x_axis))),
      y_(wide_enough(std::move(y_axis))) {
  out_ = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" role=\"img\" font-family=\"sans-serif\" font-size=\"12\">\n",
      kWidth, height_);
  for_ticks(x_, [&](double value) {
    out_ += fmt::format(
        "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\" stroke=\"#d5dbe0\"/><text "
        "x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">{4:g}</text>\n",
        x(value), top_, height_ - kBottom, height_ - kBottom + 15, value);
  });
  out_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>\n", kWidth - kRight,
                      height_ - 5, escaped_html(x_.title));
  if (y_.title.empty()) return;
  for_ticks(y_, [&](double value) {
    out_ += fmt::format(
        "<line x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"#d5dbe0\"/><text "
        "x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n",
        kLeft, kWidth - kRight, y(value), kLeft - 6, y(value) + 4, value);
  });
  out_ += fmt::format("<text x=\"4\" y=\"{}\">{}</text>\n", kTop + 4, escaped_html(y_.title));
}

double PlotFrame::x(double value) const {
  return kLeft + (value - x_.min) / (x_.max - x_.min) * (kWidth - kLeft - kRight);
}

double PlotFrame::y(double value) const {
  return height_ - kBottom - (value - y_.min) / (y_.max - y_.min) * (height_ - kBottom - top_);
}

void PlotFrame::band(double from_x, double to_x, double from_y, double to_y, const char* colour,
                     double opacity, const std::string& title) {
  out_ += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\" "
      "fill-opacity=\"{}\"><title>{}</title></rect>\n",
      x(from_x), y(to_y), std::max(1.0, x(to_x) - x(from_x)), y(from_y) - y(to_y), colour, opacity,
      escaped_html(title));
}

void PlotFrame::line(double at_x, const char* colour, const std::string& title) {
  out_ += fmt::format(
      "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\" stroke=\"{3}\" "
      "stroke-dasharray=\"4 3\"><title>{4}</title></line>\n",
      x(at_x), top_, height_ - kBottom, colour, escaped_html(title));
}

void PlotFrame::level(double at_y, const std::string& title) {
  out_ += fmt::format(
      "<line x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"#1d2630\" "
      "stroke-dasharray=\"4 3\"/><text x=\"{1}\" y=\"{3:.1f}\" text-anchor=\"end\">{4}</text>\n",
      kLeft, kWidth - kRight, y(at_y), y(at_y) - 3, escaped_html(title));
}

void PlotFrame::dot(double at_x, double at_y, const std::string& title) {
  out_ += fmt::format(
      "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"><title>{}</title></circle>\n",
      x(at_x), y(at_y), kBlue, escaped_html(title));
}

void PlotFrame::bar(double at_x, double at_y, double low, double high, const std::string& title) {
  out_ += fmt::format(
      "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\" "
      "stroke-width=\"2\"/>\n",
      x(at_x), y(low), y(high), kBlue);
  dot(at_x, at_y, title);
}

std::string escaped_html(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

}  // namespace aprsim::client
