#include "world/robot/path_stretch.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::robot {

void PathStretch::clear() {
  cells_.clear();
  length_ = 1;
}

void PathStretch::build(std::span<const Knot> knots) {
  cells_.clear();
  for (const Knot& knot : knots) cells_.push_back({0, knot.u, std::min(1.0, knot.rate), 0});
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
}

const PathStretch::Cell& PathStretch::cell_at(double rho) const {
  const auto after = std::upper_bound(cells_.begin(), cells_.end(), rho,
                                      [](double r, const Cell& cell) { return r < cell.rho; });
  return after == cells_.begin() ? cells_.front() : *(after - 1);
}

double PathStretch::u_at(double rho) const {
  if (cells_.empty()) return std::clamp(rho, 0.0, 1.0);
  const Cell& cell = cell_at(rho);
  const double r = std::max(0.0, rho - cell.rho);
  return std::clamp(cell.u + r * (cell.rate + r * cell.slope / 2), 0.0, 1.0);
}

double PathStretch::rate_of(double u) const {
  if (cells_.empty()) return 1;
  const auto after = std::upper_bound(cells_.begin(), cells_.end(), u,
                                      [](double x, const Cell& cell) { return x < cell.u; });
  const Cell& cell = after == cells_.begin() ? cells_.front() : *(after - 1);
  return std::sqrt(std::max(0.0, cell.rate * cell.rate + 2 * cell.slope * (u - cell.u)));
}

double PathStretch::rate_at(double rho) const {
  if (cells_.empty()) return 1;
  const Cell& cell = cell_at(rho);
  return cell.rate + std::max(0.0, rho - cell.rho) * cell.slope;
}

}  // namespace aprsim::robot
