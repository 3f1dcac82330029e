#include "world/robot/trajectory/time_scaling.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::robot {
namespace {

constexpr int kHalfWindow = 5;  ///< steps of the grid on which rates are smoothed
constexpr std::size_t kMaxGrid = 8000;
constexpr int kParts = 16;  ///< of a step, while the smoothed rates are laid out anew

/// The lowest value within `half` steps of each.
void erode(const std::vector<double>& in, int half, std::vector<double>& out) {
  const int n = static_cast<int>(in.size());
  for (int i = 0; i < n; ++i) {
    double low = in[static_cast<std::size_t>(i)];
    for (int k = std::max(0, i - half); k <= std::min(n - 1, i + half); ++k) {
      low = std::min(low, in[static_cast<std::size_t>(k)]);
    }
    out[static_cast<std::size_t>(i)] = low;
  }
}

/// The mean within `half` steps of each; beyond the ends the values there.
void average(const std::vector<double>& in, int half, std::vector<double>& out) {
  const int n = static_cast<int>(in.size());
  for (int i = 0; i < n; ++i) {
    double sum = 0;
    for (int k = i - half; k <= i + half; ++k) {
      sum += in[static_cast<std::size_t>(std::clamp(k, 0, n - 1))];
    }
    out[static_cast<std::size_t>(i)] = sum / (2 * half + 1);
  }
}

}  // namespace

void TimeScaling::reserve(std::size_t knots) {
  cells_.reserve(std::max(knots, kMaxGrid + 2));
  rates_.reserve(kMaxGrid + 2);
  work_.reserve(kMaxGrid + 2);
}

void TimeScaling::clear() {
  cells_.clear();
  length_ = 1;
}

void TimeScaling::build(std::span<const Knot> knots, double window) {
  cells_.clear();
  for (const Knot& knot : knots) cells_.push_back({0, knot.u, std::min(1.0, knot.rate), 0, 0});
  const std::size_t n = cells_.size();
  // rate^2 changes by at most 2 * slope * du: once forwards, once backwards.
  const auto reach = [&](std::size_t from, std::size_t to) {
    const double du = std::abs(cells_[to].u - cells_[from].u);
    const double slope = std::min(knots[from].slope, knots[to].slope);
    return std::sqrt(cells_[from].rate * cells_[from].rate + 2 * slope * du);
  };
  for (std::size_t i = 1; i < n; ++i) {
    cells_[i].rate = std::min(cells_[i].rate, reach(i - 1, i));
  }
  for (std::size_t i = n - 1; i-- > 0;) {
    cells_[i].rate = std::min(cells_[i].rate, reach(i + 1, i));
  }
  for (std::size_t i = 0; i + 1 < n; ++i) {
    Cell& cell = cells_[i];
    Cell& next = cells_[i + 1];
    const double du = next.u - cell.u;
    cell.slope = (next.rate * next.rate - cell.rate * cell.rate) / (2 * du);
    next.rho = cell.rho + 2 * du / (cell.rate + next.rate);
  }
  length_ = cells_.back().rho;
  if (window > 0) smooth(window);
}

/// Takes the lowest rate within the window and then the mean within it: nowhere faster than
/// before, and the slope no steeper.
void TimeScaling::smooth(double window) {
  const double step =
      std::max(window / (2 * kHalfWindow), length_ / static_cast<double>(kMaxGrid - 2));
  const auto grid = static_cast<std::size_t>(std::ceil(length_ / step)) + 1;
  rates_.resize(grid);
  work_.resize(grid);
  for (std::size_t i = 0; i < grid; ++i) {
    rates_[i] = rate_at(std::min(length_, static_cast<double>(i) * step));
  }
  for (const Cell& cell : cells_) {  // dips between two points of the grid
    const auto i = std::min(static_cast<std::size_t>(cell.rho / step), grid - 1);
    rates_[i] = std::min(rates_[i], cell.rate);
    if (i + 1 < grid) rates_[i + 1] = std::min(rates_[i + 1], cell.rate);
  }
  // One step more, for what the means below and the grid itself take.
  erode(rates_, kHalfWindow + 2, work_);
  average(work_, kHalfWindow, rates_);

  // The smoothed rates by u, while the cells of before are still there.
  work_.clear();
  const double end = length_;
  const auto rate_here = [&](double rho) {
    const double x = std::min(rho, end) / step;
    const auto i = std::min(static_cast<std::size_t>(x), grid - 1);
    const auto j = std::min(i + 1, grid - 1);
    return rates_[i] + (x - static_cast<double>(i)) * (rates_[j] - rates_[i]);
  };
  // Along the new rho the old one advances as the rates differ.
  double total = 0;
  for (std::size_t i = 0; i + 1 < grid; ++i) {
    const double from = static_cast<double>(i) * step, to = std::min(end, from + step);
    const double part = (to - from) / kParts;
    for (int k = 0; k < kParts; ++k) {
      const double middle = from + (k + 0.5) * part;
      total += part * rate_at(middle) / rate_here(middle);
    }
  }
  const auto steps = static_cast<std::size_t>(std::ceil(total / step));
  const double stride = total / static_cast<double>(steps);
  double rho = 0;
  for (std::size_t i = 0; i < steps; ++i) {
    work_.push_back(rate_here(rho));
    for (int k = 0; k < kParts; ++k) {
      const double half = 0.5 * stride / kParts * rate_here(rho) / rate_at(rho);
      const double middle = std::min(end, rho + half);
      rho = std::min(end, rho + stride / kParts * rate_here(middle) / rate_at(middle));
    }
  }
  work_.push_back(rate_here(end));
  lay_cells(stride);
}

/// Cells of equal length through the rates of work_.
void TimeScaling::lay_cells(double step) {
  const std::size_t n = work_.size();
  cells_.clear();
  const auto slope = [&](std::size_t i) {
    const std::size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, n - 1);
    return b > a ? (work_[b] - work_[a]) / (static_cast<double>(b - a) * step) : 0.0;
  };
  Cell cell{0, 0, work_[0], slope(0), 0};
  double rho_new = 0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double next_slope = slope(i + 1);
    cell.curve = (next_slope - cell.slope) / step;
    cells_.push_back(cell);
    rho_new += step;
    cell = {rho_new, cell.u + step * (cell.rate + step * (cell.slope / 2 + step * cell.curve / 6)),
            cell.rate + step * (cell.slope + step * cell.curve / 2), next_slope, 0};
  }
  cells_.push_back({cell.rho, cell.u, cell.rate, 0, 0});
  const double scale = 1 / cell.u;  // 1 but for what the integration leaves
  length_ = rho_new * scale;
  for (Cell& each : cells_) {
    each.rho *= scale;
    each.u *= scale;
    each.slope /= scale;
    each.curve /= scale * scale;
  }
}

const TimeScaling::Cell& TimeScaling::cell_at(double rho) const {
  const auto after = std::upper_bound(cells_.begin(), cells_.end(), rho,
                                      [](double r, const Cell& cell) { return r < cell.rho; });
  return after == cells_.begin() ? cells_.front() : *(after - 1);
}

double TimeScaling::u_at(double rho) const {
  if (cells_.empty()) return std::clamp(rho, 0.0, 1.0);
  const Cell& cell = cell_at(rho);
  const double r = std::max(0.0, rho - cell.rho);
  return std::clamp(cell.u + r * (cell.rate + r * (cell.slope / 2 + r * cell.curve / 6)), 0.0, 1.0);
}

double TimeScaling::rate_at(double rho) const {
  if (cells_.empty()) return 1;
  const Cell& cell = cell_at(rho);
  const double r = std::max(0.0, rho - cell.rho);
  return cell.rate + r * (cell.slope + r * cell.curve / 2);
}

double TimeScaling::rate_of(double u) const {
  if (cells_.empty()) return 1;
  const auto after = std::upper_bound(cells_.begin(), cells_.end(), u,
                                      [](double x, const Cell& cell) { return x < cell.u; });
  const Cell& cell = after == cells_.begin() ? cells_.front() : *(after - 1);
  // The cells are short: their slope is nearly even.
  return std::sqrt(std::max(0.0, cell.rate * cell.rate + 2 * cell.slope * (u - cell.u)));
}

}  // namespace aprsim::robot
