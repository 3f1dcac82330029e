#include "world/physics/constraint/mixed_lcp.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "world/physics/constraint/cholesky.hpp"

namespace aprsim::physics {
namespace {

constexpr double kConverged = 1e-5;  // change of an x, of the largest, that ends relaxation
constexpr double kOnBound = 1e-10;   // of the largest x
constexpr double kStill = 1e-11;     // [m/s] of w that does not count
constexpr int kChances = 4;          // pivoting rounds without fewer misplaced rows
constexpr int kManyAtOnce = 10, kMostRounds = 300;  // rounds; later one row at a time

using Values = Eigen::Map<Eigen::VectorXd>;
using ConstValues = Eigen::Map<const Eigen::VectorXd>;

}  // namespace

int MixedLcp::add(const Row& row, double guess) {
  if (rows_ == kCapacity) {
    throw std::length_error("a contact problem of more than " + std::to_string(kCapacity) +
                            " rows");
  }
  const int i = rows_++;
  row_[at(i)] = row;
  std::fill_n(column(i), kCapacity, 0.0);
  b_[at(i)] = 0;
  x_[at(i)] = guess;
  return i;
}

/// Projected Gauss-Seidel; friction is clamped by the normal of the same sweep.
void MixedLcp::relax(int most_rounds) {
  const int n = rows_;
  // w holds b - A x here, kept up to date row by row.
  std::copy_n(b_.data(), n, w_.data());
  for (int i = 0; i < n; ++i) {
    y_[at(i)] = 1 / column(i)[i];
    if (x_[at(i)] != 0) subtract(x_[at(i)], column(i), w_.data(), n);
  }
  double largest = 0;
  for (int round = 1; round <= most_rounds; ++round) {
    double change = 0;
    for (int i = 0; i < n; ++i) {
      const Row& row = row_[at(i)];
      double lo = row.lo, hi = row.hi;
      if (row.normal >= 0) {
        hi = row.mu * x_[at(row.normal)];
        lo = -hi;
      }
      const double x = std::clamp(x_[at(i)] + w_[at(i)] * y_[at(i)], lo, hi);
      const double delta = x - x_[at(i)];
      if (delta == 0) continue;
      x_[at(i)] = x;
      subtract(delta, column(i), w_.data(), n);
      change = std::max(change, std::abs(delta));
      largest = std::max(largest, std::abs(x));
    }
    if (change <= kConverged * largest) return;
  }
}

/// Friction bounds from the present normals.
void MixedLcp::fix_friction_bounds() {
  for (int i = 0; i < rows_; ++i) {
    const Row& row = row_[at(i)];
    lo_[at(i)] = row.lo;
    hi_[at(i)] = row.hi;
    if (row.normal < 0) continue;
    hi_[at(i)] = row.mu * std::max(0.0, x_[at(row.normal)]);
    lo_[at(i)] = -hi_[at(i)];
  }
}

bool MixedLcp::solve_estimated(int most_rounds) {
  relax(most_rounds);
  fix_friction_bounds();
  return solve_for_bounds();
}

bool MixedLcp::solve_decoupled() {
  for (int i = 0; i < rows_; ++i) {
    const Row& row = row_[at(i)];
    lo_[at(i)] = row.lo;
    hi_[at(i)] = row.hi;
    if (row.normal >= 0) lo_[at(i)] = hi_[at(i)] = 0;
  }
  const bool without_friction = solve_for_bounds();
  fix_friction_bounds();
  return solve_for_bounds() && without_friction;
}

int MixedLcp::list_free() {
  int count = 0;
  for (int i = 0; i < rows_; ++i) {
    if (state_[at(i)] == RowState::kFree) free_[at(count++)] = i;
  }
  return count;
}

/// z: x with the free rows replaced by the solution of their equations, the others given.
void MixedLcp::solve_free() {
  const int n = rows_;
  // What the given rows leave of b.
  Numbers rest, y;
  std::copy_n(b_.data(), n, rest.data());
  for (int i = 0; i < n; ++i) {
    z_[at(i)] = x_[at(i)];
    if (state_[at(i)] != RowState::kFree && x_[at(i)] != 0) {
      subtract(x_[at(i)], column(i), rest.data(), n);
    }
  }
  // Cholesky factorisation of the free block.
  const int count = list_free();
  for (int k = 0; k < count; ++k) {
    const double* from = column(free_[at(k)]);
    double* to = factor_.data() + at(k) * kCapacity;
    for (int m = k; m < count; ++m) to[m] = from[free_[at(m)]];
    y[at(k)] = rest[at(free_[at(k)])];
  }
  factorise(factor_.data(), count, kCapacity);
  solve_lower(factor_.data(), count, kCapacity, y.data());
  solve_lower_transposed(factor_.data(), count, kCapacity, y.data());
  for (int k = 0; k < count; ++k) z_[at(free_[at(k)])] = y[at(k)];
}

void MixedLcp::find_w(const Numbers& x, Numbers& w) const {
  for (int i = 0; i < rows_; ++i) w[at(i)] = -b_[at(i)];
  for (int i = 0; i < rows_; ++i) {
    if (x[at(i)] != 0) subtract(-x[at(i)], column(i), w.data(), rows_);
  }
}

double MixedLcp::slack() const {
  return kOnBound * ConstValues(x_.data(), rows_).cwiseAbs().maxCoeff();
}

/// Projected step from x towards z: to the point of the box that is nearest to z, if the energy
/// x A x / 2 - b x falls, or else straight until the first row meets its bound. True when it got to
/// z.
bool MixedLcp::step_to_free_solution() {
  const double slack = this->slack();
  bool inside = true;
  for (int i = 0; i < rows_; ++i) {
    y_[at(i)] = std::clamp(z_[at(i)], lo_[at(i)], hi_[at(i)]);
    inside = inside && std::abs(y_[at(i)] - z_[at(i)]) <= slack;
  }
  if (inside) {
    x_ = z_;
    find_w(x_, w_);
    return true;
  }
  const int n = rows_;
  find_w(y_, w_next_);
  const Values x(x_.data(), n), y(y_.data(), n), w(w_.data(), n), w_next(w_next_.data(), n);
  // The energy's change along y - x is (y - x) (w + w_next) / 2.
  double step = 1;
  if ((y - x).dot(w + w_next) >= 0) {
    for (int i = 0; i < n; ++i) {
      const double way = z_[at(i)] - x_[at(i)];
      if (way == 0 || y_[at(i)] == z_[at(i)]) continue;
      step = std::min(step, std::max(0.0, (y_[at(i)] - x_[at(i)]) / way));
    }
    for (int i = 0; i < n; ++i) {
      const double to = x_[at(i)] + step * (z_[at(i)] - x_[at(i)]);
      y_[at(i)] = std::clamp(to, lo_[at(i)], hi_[at(i)]);
    }
    find_w(y_, w_next_);
  }
  for (int i = 0; i < n; ++i) {
    if (state_[at(i)] != RowState::kFree) continue;
    // The row that ends a straight way is at its bound, whatever rounding says.
    const double way = z_[at(i)] - x_[at(i)], bound = way < 0 ? lo_[at(i)] : hi_[at(i)];
    const bool ends = step < 1 && way != 0 && (bound - x_[at(i)]) / way <= step;
    if (ends) y_[at(i)] = bound;
    if (ends || y_[at(i)] != z_[at(i)]) set_state(i, y_[at(i)]);
  }
  x_ = y_;
  w_ = w_next_;
  return false;
}

void MixedLcp::set_state(int i, double x) {
  RowState& state = state_[at(i)];
  if (lo_[at(i)] == hi_[at(i)]) {
    state = RowState::kLocked;
  } else if (x <= lo_[at(i)]) {
    state = RowState::kLow;
  } else {
    state = x >= hi_[at(i)] ? RowState::kHigh : RowState::kFree;
  }
}

/// Frees rows whose w has the wrong sign for their bound: all, or the worst one. False: there is
/// none.
bool MixedLcp::release(bool all) {
  double most = kStill;
  int worst = -1;
  for (int i = 0; i < rows_; ++i) {
    RowState& state = state_[at(i)];
    if (state == RowState::kFree || state == RowState::kLocked) continue;
    const double wrong = state == RowState::kLow ? -w_[at(i)] : w_[at(i)];
    if (wrong <= kStill) continue;
    if (all) state = RowState::kFree;
    if (wrong > most) {
      most = wrong;
      worst = i;
    }
  }
  if (worst >= 0) state_[at(worst)] = RowState::kFree;
  return worst >= 0;
}

/// Block principal pivoting (Judice & Pires 1994): exchanges all misplaced rows at once. It may go
/// round in circles; as there, a few rounds without progress are allowed. Where Judice and Pires
/// then exchange one row at a time, this gives up with x as before, and active sets go on.
bool MixedLcp::pivot_blocks() {
  y_ = x_;
  int fewest = rows_ + 1, chances = kChances;
  while (true) {
    // Complementary basic solution of the present states.
    for (int i = 0; i < rows_; ++i) {
      if (state_[at(i)] == RowState::kLow || state_[at(i)] == RowState::kLocked)
        x_[at(i)] = lo_[at(i)];
      if (state_[at(i)] == RowState::kHigh) x_[at(i)] = hi_[at(i)];
    }
    solve_free();
    x_ = z_;
    find_w(x_, w_);
    const int exchanged = exchange_misplaced();
    if (exchanged == 0) return true;
    if (exchanged < fewest) {
      fewest = exchanged;
      chances = kChances;
    } else if (--chances == 0) {
      x_ = y_;
      return false;
    }
  }
}

/// Free rows beyond a bound go to it, rows at a bound with the wrong sign of w become free. Returns
/// how many there were.
int MixedLcp::exchange_misplaced() {
  const double slack = this->slack();
  int exchanged = 0;
  for (int i = 0; i < rows_; ++i) {
    RowState& state = state_[at(i)];
    RowState to = state;
    if (state == RowState::kFree) {
      if (x_[at(i)] < lo_[at(i)] - slack) to = RowState::kLow;
      if (x_[at(i)] > hi_[at(i)] + slack) to = RowState::kHigh;
    } else if ((state == RowState::kLow && w_[at(i)] < -kStill) ||
               (state == RowState::kHigh && w_[at(i)] > kStill)) {
      to = RowState::kFree;
    }
    exchanged += to != state;
    state = to;
  }
  return exchanged;
}

/// x onto the box.
void MixedLcp::project() {
  for (int i = 0; i < rows_; ++i) {
    x_[at(i)] = std::clamp(x_[at(i)], lo_[at(i)], hi_[at(i)]);
    set_state(i, x_[at(i)]);
  }
}

/// Exactly for the present bounds, from the present x.
bool MixedLcp::solve_for_bounds() {
  project();
  return pivot_blocks() || solve_active_set();
}

/// Primal active-set method for the convex quadratic programme of the same solution (Nocedal &
/// Wright 2006, ch. 16.5, with projected steps as in ch. 16.7): the energy x A x / 2 - b x falls in
/// every round, so it ends.
bool MixedLcp::solve_active_set() {
  project();
  find_w(x_, w_);
  for (int round = 0; round < kMostRounds; ++round) {
    solve_free();
    if (step_to_free_solution() && !release(round < kManyAtOnce)) return true;
  }
  return false;
}

}  // namespace aprsim::physics
