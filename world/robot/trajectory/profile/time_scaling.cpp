#include "world/robot/trajectory/profile/time_scaling.hpp"

#include <algorithm>
#include <cmath>

// Highest rates under limits of the rate and its slope: the velocity curve of Bobrow, Dubowsky &
// Gibson 1985, found by a forward and a backward pass over the squared rate, which is linear in u
// under a constant slope (Verscheure et al. 2009). Deviation: the slope limit is one number a
// sample; smoothing then bounds the change of the slope.

namespace aprsim::robot {
namespace {

constexpr int kHalfWindow = 5;  ///< steps of the grid on which rates are smoothed
constexpr std::size_t kMaxGrid = 8000;
constexpr int kParts = 16;  ///< of a step, while the smoothed rates are integrated

/// Erosion: the lowest value within `half` steps of each.
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

/// Moving average over `half` steps to either side; beyond the ends the values there.
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

void TimeScaling::clear() {
  pieces_.clear();
  length_ = 1;
}

void TimeScaling::build(std::span<const RateLimit> limits, double window) {
  pieces_.clear();
  for (const RateLimit& limit : limits)
    pieces_.push_back({0, limit.u, std::min(1.0, limit.rate), 0, 0});
  const std::size_t n = pieces_.size();
  // The squared rate changes by at most 2 slope du.
  const auto reach = [&](std::size_t from, std::size_t to) {
    const double du = std::abs(pieces_[to].u - pieces_[from].u);
    const double slope = std::min(limits[from].slope, limits[to].slope);
    return std::sqrt(pieces_[from].rate * pieces_[from].rate + 2 * slope * du);
  };
  // The forward pass bounds acceleration, the backward pass deceleration; their minimum is the
  // highest admissible curve (Kunz & Stilman 2012 integrate the same limit curve in the phase
  // plane).
  // Forward and backward pass.
  for (std::size_t i = 1; i < n; ++i) {
    pieces_[i].rate = std::min(pieces_[i].rate, reach(i - 1, i));
  }
  for (std::size_t i = n - 1; i-- > 0;) {
    pieces_[i].rate = std::min(pieces_[i].rate, reach(i + 1, i));
  }
  // Pieces of constant slope and their rho.
  for (std::size_t i = 0; i + 1 < n; ++i) {
    Piece& piece = pieces_[i];
    Piece& next = pieces_[i + 1];
    const double du = next.u - piece.u;
    piece.slope = (next.rate * next.rate - piece.rate * piece.rate) / (2 * du);
    next.rho = piece.rho + 2 * du / (piece.rate + next.rate);
  }
  length_ = pieces_.back().rho;
  if (window > 0) smooth(window);
  rates_ = {};
  work_ = {};
}

/// Erosion by the window, then the moving average over it: nowhere faster than before, and the
/// slope no steeper.
void TimeScaling::smooth(double window) {
  // The rates on an even grid.
  const double step =
      std::max(window / (2 * kHalfWindow), length_ / static_cast<double>(kMaxGrid - 2));
  const auto grid = static_cast<std::size_t>(std::ceil(length_ / step)) + 1;
  rates_.resize(grid);
  work_.resize(grid);
  for (std::size_t i = 0; i < grid; ++i) {
    rates_[i] = rate_at(std::min(length_, static_cast<double>(i) * step));
  }
  for (const Piece& piece : pieces_) {  // minima between two points of the grid
    const auto i = std::min(static_cast<std::size_t>(piece.rho / step), grid - 1);
    rates_[i] = std::min(rates_[i], piece.rate);
    if (i + 1 < grid) rates_[i + 1] = std::min(rates_[i + 1], piece.rate);
  }
  // Wider by the steps that average and grid reach beyond it.
  erode(rates_, kHalfWindow + 2, work_);
  average(work_, kHalfWindow, rates_);

  // The smoothed rates as functions of u, by way of the unsmoothed pieces.
  work_.clear();
  const double end = length_;
  const auto rate_here = [&](double rho) {
    const double x = std::min(rho, end) / step;
    const auto i = std::min(static_cast<std::size_t>(x), grid - 1);
    const auto j = std::min(i + 1, grid - 1);
    return rates_[i] + (x - static_cast<double>(i)) * (rates_[j] - rates_[i]);
  };
  // Length of the new rho: d(rho_new) = rate_old / rate_new d(rho_old).
  double total = 0;
  for (std::size_t i = 0; i + 1 < grid; ++i) {
    const double from = static_cast<double>(i) * step, to = std::min(end, from + step);
    const double part = (to - from) / kParts;
    for (int k = 0; k < kParts; ++k) {
      const double middle = from + (k + 0.5) * part;
      total += part * rate_at(middle) / rate_here(middle);
    }
  }
  // The new rates at even steps of the new rho (midpoint rule).
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
  fit_pieces(stride);
}

/// Pieces of equal length through the rates in work_, with continuous slope.
void TimeScaling::fit_pieces(double step) {
  const std::size_t n = work_.size();
  pieces_.clear();
  const auto slope = [&](std::size_t i) {
    const std::size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, n - 1);
    return b > a ? (work_[b] - work_[a]) / (static_cast<double>(b - a) * step) : 0.0;
  };
  Piece piece{0, 0, work_[0], slope(0), 0};
  double rho_new = 0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double next_slope = slope(i + 1);
    piece.curvature = (next_slope - piece.slope) / step;
    pieces_.push_back(piece);
    rho_new += step;
    piece = {rho_new,
             piece.u + step * (piece.rate + step * (piece.slope / 2 + step * piece.curvature / 6)),
             piece.rate + step * (piece.slope + step * piece.curvature / 2), next_slope, 0};
  }
  pieces_.push_back({piece.rho, piece.u, piece.rate, 0, 0});
  // Corrects the integration error, so that u ends at 1.
  const double scale = 1 / piece.u;
  length_ = rho_new * scale;
  for (Piece& each : pieces_) {
    each.rho *= scale;
    each.u *= scale;
    each.slope /= scale;
    each.curvature /= scale * scale;
  }
}

const TimeScaling::Piece& TimeScaling::piece_at(double rho) const {
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), rho,
                                      [](double r, const Piece& piece) { return r < piece.rho; });
  return after == pieces_.begin() ? pieces_.front() : *(after - 1);
}

double TimeScaling::u_at(double rho) const {
  if (pieces_.empty()) return std::clamp(rho, 0.0, 1.0);
  const Piece& piece = piece_at(rho);
  const double r = std::max(0.0, rho - piece.rho);
  return std::clamp(piece.u + r * (piece.rate + r * (piece.slope / 2 + r * piece.curvature / 6)),
                    0.0, 1.0);
}

double TimeScaling::rate_at(double rho) const {
  if (pieces_.empty()) return 1;
  const Piece& piece = piece_at(rho);
  const double r = std::max(0.0, rho - piece.rho);
  return piece.rate + r * (piece.slope + r * piece.curvature / 2);
}

double TimeScaling::rate_of(double u) const {
  if (pieces_.empty()) return 1;
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), u,
                                      [](double x, const Piece& piece) { return x < piece.u; });
  const Piece& piece = after == pieces_.begin() ? pieces_.front() : *(after - 1);
  // The pieces are short: constant slope.
  return std::sqrt(std::max(0.0, piece.rate * piece.rate + 2 * piece.slope * (u - piece.u)));
}

}  // namespace aprsim::robot
