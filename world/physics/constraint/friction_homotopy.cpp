#include "world/physics/constraint/friction_homotopy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "world/physics/constraint/cholesky.hpp"

namespace aprsim::physics {
namespace {

constexpr double kNoError = 1e-12;  // of the bound
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

bool FrictionHomotopy::continue_friction(MixedLcp& lcp, int most_changes) {
  lcp_ = &lcp;
  rows_ = lcp.rows();
  state_ = lcp.states();
  find_errors();
  double residual = 1, direction = -1;
  Change last;
  for (int changes = 0; changes <= most_changes; ++changes) {
    if (!find_piece()) return false;
    // Forwards or backwards: away from the state that was just left.
    if (last.row >= 0) {
      const double forwards = direction_after(last);
      if (forwards == 0) return false;
      direction = forwards > 0 ? 1 : -1;
    }
    const Change next = next_change(residual, direction, last);
    if (next.row < 0) {
      // No more change before residual 0, or none at all on a path that leads away from it.
      if (direction < 0) lcp.set_x(x_.end);
      return direction < 0;
    }
    residual += direction * next.distance;
    apply(next, residual);
    last = next;
  }
  return false;
}

/// Of the bounds that the starting solution was found with, against those of its own normals.
void FrictionHomotopy::find_errors() {
  for (int i = 0; i < rows_; ++i) {
    double& error = error_[at(i)];
    error = 0;
    if (row(i).normal < 0) continue;
    const double bound = lcp_->upper_bound(i);
    error = bound - row(i).mu * std::max(0.0, lcp_->x(row(i).normal));
    if (std::abs(error) <= kNoError * bound) error = 0;
  }
}

double FrictionHomotopy::bound_end(int i) const { return row(i).mu * x_.end[at(row(i).normal)]; }

double FrictionHomotopy::bound_slope(int i) const {
  return row(i).mu * x_.slope[at(row(i).normal)] + error_[at(i)];
}

int FrictionHomotopy::list_free() {
  int count = 0;
  for (int i = 0; i < rows_; ++i) {
    const bool free = state_[at(i)] == RowState::kFree;
    place_[at(i)] = free ? count : -1;
    if (free) free_[at(count++)] = i;
  }
  return count;
}

/// The equations of the free rows, for the values at residual 0 (`right`) and for those by residual
/// (`slope`). Friction at its bounds moves with its normal, so its column adds to the normal's: the
/// matrix is not symmetric. Returns the number of free rows.
int FrictionHomotopy::gather_equations(Numbers& right, Numbers& slope) {
  const int n = rows_, count = list_free();
  std::copy_n(lcp_->b().data(), n, right.data());
  std::fill_n(slope.data(), n, 0.0);
  for (int k = 0; k < count; ++k) {
    const double* from = lcp_->column(free_[at(k)]);
    double* to = factor_.data() + at(k) * MixedLcp::kCapacity;
    for (int m = 0; m < count; ++m) to[m] = from[free_[at(m)]];
  }
  for (int i = 0; i < n; ++i) {
    const RowState state = state_[at(i)];
    x_.end[at(i)] = x_.slope[at(i)] = 0;
    if (state == RowState::kFree || state == RowState::kLocked) continue;
    // A row at a constant bound is a number on the right side.
    if (row(i).normal < 0) {
      const double x = state == RowState::kLow ? row(i).lo : row(i).hi;
      x_.end[at(i)] = x;
      if (x != 0) subtract(x, lcp_->column(i), right.data(), n);
      continue;
    }
    // Friction at its bound: the error is a number, the rest a multiple of the normal.
    if (error_[at(i)] != 0) subtract(sign(i) * error_[at(i)], lcp_->column(i), slope.data(), n);
    const int k = place_[at(row(i).normal)];
    if (k < 0) continue;
    const double* from = lcp_->column(i);
    double* to = factor_.data() + at(k) * MixedLcp::kCapacity;
    for (int m = 0; m < count; ++m) to[m] += sign(i) * row(i).mu * from[free_[at(m)]];
  }
  return count;
}

/// x and w on the piece of the path with the present states; false when it is not determined.
bool FrictionHomotopy::find_piece() {
  const int count = gather_equations(right_, slope_);
  Numbers right, slope;
  for (int k = 0; k < count; ++k) {
    right[at(k)] = right_[at(free_[at(k)])];
    slope[at(k)] = slope_[at(free_[at(k)])];
  }
  if (!solve_two(factor_.data(), count, MixedLcp::kCapacity, right.data(), slope.data())) {
    return false;
  }
  for (int k = 0; k < count; ++k) {
    x_.end[at(free_[at(k)])] = right[at(k)];
    x_.slope[at(free_[at(k)])] = slope[at(k)];
  }
  // Friction at its bounds follows from its normal.
  for (int i = 0; i < rows_; ++i) {
    if (row(i).normal < 0) continue;
    if (state_[at(i)] != RowState::kLow && state_[at(i)] != RowState::kHigh) continue;
    x_.end[at(i)] = sign(i) * bound_end(i);
    x_.slope[at(i)] = sign(i) * bound_slope(i);
  }
  lcp_->find_w(x_.end, w_.end);
  std::fill_n(w_.slope.data(), rows_, 0.0);
  for (int i = 0; i < rows_; ++i) {
    const double x = x_.slope[at(i)];
    if (x != 0) subtract(-x, lcp_->column(i), w_.slope.data(), rows_);
  }
  return true;
}

/// The change of the residual that takes the row that has just changed further into its new state.
double FrictionHomotopy::direction_after(const Change& last) const {
  const int i = last.row;
  const double x = x_.slope[at(i)], w = w_.slope[at(i)];
  if (last.to == RowState::kLocked) return -bound_slope(i);
  if (last.from == RowState::kLocked) return bound_slope(i);
  if (last.to == RowState::kLow) return w;
  if (last.to == RowState::kHigh) return -w;
  const double bound = row(i).normal >= 0 ? bound_slope(i) : 0;
  return last.from == RowState::kLow ? x + bound : bound - x;
}

/// A friction row that is allowed a force again acts against its velocity.
MixedLcp::RowState FrictionHomotopy::state_when_unlocked(int i, double residual) const {
  return w_.at(i, residual) > 0 ? RowState::kLow : RowState::kHigh;
}

/// The first row whose state ends on the way on from `residual`: a free x that meets a bound, a w
/// at a bound that vanishes, a bound of friction that becomes or stops being zero.
FrictionHomotopy::Change FrictionHomotopy::next_change(double residual, double direction,
                                                       const Change& last) const {
  Change next{.distance = direction < 0 ? residual : kInfinity};
  // Where a value that is positive now, end + residual slope, comes down to zero.
  const auto meet = [&](int i, double end, double slope, RowState to) {
    const double falls = -direction * slope;
    if (falls <= 0 || (i == last.row && to == last.from)) return;
    const double distance = std::max(0.0, (end + residual * slope) / falls);
    if (distance < next.distance) next = {i, state_[at(i)], to, distance};
  };
  for (int i = 0; i < rows_; ++i) {
    const RowState state = state_[at(i)];
    const bool friction = row(i).normal >= 0;
    if (friction ? row(i).mu == 0 : row(i).lo == row(i).hi) continue;
    const double x = x_.end[at(i)], dx = x_.slope[at(i)];
    const double w = w_.end[at(i)], dw = w_.slope[at(i)];
    const double bound = friction ? bound_end(i) : 0, dbound = friction ? bound_slope(i) : 0;
    if (state == RowState::kFree) {
      meet(i, friction ? x + bound : x - row(i).lo, dx + dbound, RowState::kLow);
      if (friction || row(i).hi < kInfinity) {
        meet(i, friction ? bound - x : row(i).hi - x, dbound - dx, RowState::kHigh);
      }
    } else if (state == RowState::kLocked) {
      if (error_[at(i)] != 0) meet(i, -bound, -dbound, state_when_unlocked(i, residual));
    } else {
      meet(i, -sign(i) * w, -sign(i) * dw, RowState::kFree);
      if (friction && error_[at(i)] != 0) meet(i, bound, dbound, RowState::kLocked);
    }
  }
  return next;
}

/// The two friction rows of a contact are locked and unlocked together; without an error of their
/// own they are so with their normal.
void FrictionHomotopy::apply(const Change& change, double residual) {
  const int normal = row(change.row).normal;
  state_[at(change.row)] = change.to;
  const bool of_bound = change.from == RowState::kLocked || change.to == RowState::kLocked;
  if (normal >= 0 && !of_bound) return;
  for (int i = 0; i < rows_; ++i) {
    if (i == change.row || row(i).normal < 0 || row(i).mu == 0) continue;
    if (normal >= 0 && row(i).normal == normal) {
      state_[at(i)] =
          change.to == RowState::kLocked ? RowState::kLocked : state_when_unlocked(i, residual);
    } else if (row(i).normal == change.row && error_[at(i)] == 0) {
      state_[at(i)] =
          change.to == RowState::kFree ? state_when_unlocked(i, residual) : RowState::kLocked;
    }
  }
}

}  // namespace aprsim::physics
