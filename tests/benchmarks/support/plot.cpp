#include "tests/benchmarks/support/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/benchmarks/support/table.hpp"

namespace aprsim::bench {
namespace {

constexpr double kWidth = 760, kHeight = 440, kLeft = 84, kRight = 200, kTop = 40, kBottom = 56;
constexpr std::array kColours = {"#1f77b4", "#d62728", "#2ca02c", "#9467bd",
                                 "#ff7f0e", "#17becf", "#8c564b", "#7f7f7f"};

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "&lt;";
    } else if (c == '&') {
      out += "&amp;";
    } else {
      out += c;
    }
  }
  return out;
}

std::string text_at(double x, double y, const std::string& anchor, const std::string& text,
                    const std::string& more = "") {
  return "<text x=\"" + number_text(x) + "\" y=\"" + number_text(y) + "\" text-anchor=\"" + anchor +
         "\"" + more + ">" + escaped(text) + "</text>\n";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& colour) {
  return "<line x1=\"" + number_text(x1) + "\" y1=\"" + number_text(y1) + "\" x2=\"" +
         number_text(x2) + "\" y2=\"" + number_text(y2) + "\" stroke=\"" + colour + "\"/>\n";
}

/// One axis' way from values to the unit interval, with its ticks.
class Scale {
 public:
  Scale(const Axis& axis, const std::vector<double>& values) : log_(axis.log) {
    double low = std::numeric_limits<double>::infinity(), high = -low, least = low;
    for (const double value : values) {
      low = std::min(low, value);
      high = std::max(high, value);
      if (value > 0) least = std::min(least, value);
    }
    if (log_) {
      floor_ = axis.floor > 0 ? axis.floor : (std::isfinite(least) ? least : 1);
      low_ = std::floor(std::log10(floor_) + 1e-9);
      high_ = std::max(std::ceil(std::log10(std::max(high, floor_)) - 1e-9), low_ + 1);
      step_ = std::max(1.0, std::ceil((high_ - low_) / 10));
      return;
    }
    if (!std::isfinite(low)) low = high = 0;
    if (low > 0 && low < 0.5 * high) low = 0;
    if (high <= low) high = low + 1;
    const double rough = (high - low) / 6, decade = std::pow(10, std::floor(std::log10(rough)));
    const double mantissa = rough / decade;
    step_ = decade * (mantissa <= 1 ? 1 : mantissa <= 2 ? 2 : mantissa <= 5 ? 5 : 10);
    low_ = std::floor(low / step_ + 1e-9) * step_;
    high_ = std::ceil(high / step_ - 1e-9) * step_;
  }

  [[nodiscard]] double at(double value) const {
    const double shown = log_ ? std::log10(std::max(value, floor_)) : value;
    return (shown - low_) / (high_ - low_);
  }

  /// Fraction and label of every tick.
  [[nodiscard]] std::vector<std::pair<double, std::string>> ticks() const {
    std::vector<std::pair<double, std::string>> out;
    const int count = static_cast<int>(std::lround((high_ - low_) / step_));
    for (int i = 0; i <= count; ++i) {
      const double value = low_ + i * step_;
      if (value > high_ + 1e-9 * step_) break;
      out.emplace_back((value - low_) / (high_ - low_),
                       log_ ? "1e" + number_text(value)
                            : number_text(std::abs(value) < 1e-9 * step_ ? 0 : value));
    }
    return out;
  }

 private:
  bool log_;
  double floor_ = 1, low_ = 0, high_ = 1, step_ = 1;
};

double x_at(double fraction) { return kLeft + fraction * (kWidth - kLeft - kRight); }
double y_at(double fraction) { return kHeight - kBottom - fraction * (kHeight - kTop - kBottom); }

std::string frame(const Plot& plot, const Scale& x, const Scale& y) {
  std::string out;
  for (const auto& [fraction, label] : x.ticks()) {
    out += line(x_at(fraction), y_at(0), x_at(fraction), y_at(1), "#ddd");
    out += text_at(x_at(fraction), y_at(0) + 18, "middle", label);
  }
  for (const auto& [fraction, label] : y.ticks()) {
    out += line(x_at(0), y_at(fraction), x_at(1), y_at(fraction), "#ddd");
    out += text_at(x_at(0) - 6, y_at(fraction) + 4, "end", label);
  }
  out += line(x_at(0), y_at(0), x_at(1), y_at(0), "#333") +
         line(x_at(0), y_at(0), x_at(0), y_at(1), "#333");
  out += text_at(x_at(0.5), kHeight - 14, "middle", plot.x.label);
  out += text_at(x_at(0.5), 22, "middle", plot.title, " font-weight=\"bold\"");
  out += text_at(18, y_at(0.5), "middle", plot.y.label,
                 " transform=\"rotate(-90 18 " + number_text(y_at(0.5)) + ")\"");
  return out;
}

std::string curve(const Series& series, const Scale& x, const Scale& y, const char* colour) {
  std::string path, dots;
  for (const auto& [px, py] : series.points) {
    if (!std::isfinite(px) || !std::isfinite(py)) continue;
    const std::string at_x = number_text(x_at(x.at(px))), at_y = number_text(y_at(y.at(py)));
    path += at_x + "," + at_y + " ";
    dots += "<circle cx=\"" + at_x + "\" cy=\"" + at_y + "\" r=\"2.5\" fill=\"" + colour + "\"/>\n";
  }
  const bool marked = series.points.size() <= 60;
  return "<polyline fill=\"none\" stroke-width=\"1.5\" stroke=\"" + std::string(colour) +
         "\" points=\"" + path + "\"/>\n" + (marked ? dots : "");
}

}  // namespace

std::string Plot::svg() const {
  std::vector<double> xs, ys;
  for (const auto& one : series) {
    for (const auto& [px, py] : one.points) {
      if (!std::isfinite(px) || !std::isfinite(py)) continue;
      xs.push_back(px);
      ys.push_back(py);
    }
  }
  const Scale x_scale(x, xs), y_scale(y, ys);
  const std::string size =
      " width=\"" + number_text(kWidth) + "\" height=\"" + number_text(kHeight) + "\"";
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\"" + size +
                    " font-family=\"sans-serif\" font-size=\"12\">\n<rect" + size +
                    " fill=\"white\"/>\n" + frame(*this, x_scale, y_scale);
  for (std::size_t i = 0; i < series.size(); ++i) {
    const char* colour = kColours[i % kColours.size()];
    out += curve(series[i], x_scale, y_scale, colour);
    const double row = kTop + 10 + 18 * static_cast<double>(i);
    out += line(x_at(1) + 12, row, x_at(1) + 32, row, colour) +
           text_at(x_at(1) + 38, row + 4, "start", series[i].name);
  }
  return out + "</svg>\n";
}

}  // namespace aprsim::bench
