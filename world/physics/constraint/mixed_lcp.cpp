#include "world/physics/constraint/mixed_lcp.hpp"

#include <algorithm>
#include <cmath>

#include "world/physics/constraint/cholesky.hpp"

namespace aprsim::physics {
namespace {

constexpr double kSettled = 1e-5;   // change of an x, of the largest, that ends relaxation
constexpr double kOnBound = 1e-10;  // of the largest x
constexpr double kStill = 1e-11;    // [m/s] of w that does not count
constexpr int kChances = 4;         // rounds of exchange without fewer rows to move
constexpr int kManyAtOnce = 10, kMostRounds = 300;  // rounds; later one row at a time

using Values = Eigen::Map<Eigen::VectorXd>;
using ConstValues = Eigen::Map<const Eigen::VectorXd>;

}  // namespace

int MixedLcp::add(const Row& row, double guess) {
  const int i = rows_++;
  row_[at(i)] = row;
  std::fill_n(column(i), kCapacity, 0.0);
  b_[at(i)] = 0;
  x_[at(i)] = guess;
  return i;
}

/// Stops when nothing changes any more.
void MixedLcp::relax(int most) {
  const int n = rows_;
  std::copy_n(b_.data(), n, w_.data());
  for (int i = 0; i < n; ++i) {
    y_[at(i)] = 1 / column(i)[i];
    if (x_[at(i)] != 0) subtract(x_[at(i)], column(i), w_.data(), n);
  }
  double largest = 0;
  for (int round = 1; round <= most; ++round) {
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
    if (change <= kSettled * largest) return;
  }
}

/// Bounds of friction from the present normals.
void MixedLcp::fix_friction() {
  for (int i = 0; i < rows_; ++i) {
    const Row& row = row_[at(i)];
    lo_[at(i)] = row.lo;
    hi_[at(i)] = row.hi;
    if (row.normal < 0) continue;
    hi_[at(i)] = row.mu * std::max(0.0, x_[at(row.normal)]);
    lo_[at(i)] = -hi_[at(i)];
  }
}

bool MixedLcp::solve_together(int most_rounds, int most_changes) {
  relax(most_rounds);
  fix_friction();
  solve();
  return follow(most_changes);
}

void MixedLcp::solve_one_after_the_other() {
  for (int i = 0; i < rows_; ++i) {
    const Row& row = row_[at(i)];
    lo_[at(i)] = row.lo;
    hi_[at(i)] = row.hi;
    if (row.normal >= 0) lo_[at(i)] = hi_[at(i)] = 0;
  }
  solve();
  fix_friction();
  solve();
}

int MixedLcp::list_free() {
  int count = 0;
  for (int i = 0; i < rows_; ++i) {
    const bool free = where_[at(i)] == Where::kFree;
    place_[at(i)] = free ? count : -1;
    if (free) free_[at(count++)] = i;
  }
  return count;
}

/// z: of free rows, where A z = b with the others where they are; of the others, where they are.
void MixedLcp::solve_free() {
  const int n = rows_;
  Numbers rest, y;
  std::copy_n(b_.data(), n, rest.data());
  for (int i = 0; i < n; ++i) {
    z_[at(i)] = x_[at(i)];
    if (where_[at(i)] != Where::kFree && x_[at(i)] != 0) {
      subtract(x_[at(i)], column(i), rest.data(), n);
    }
  }
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

/// w = A x - b.
void MixedLcp::find_w(const double* x, double* w) const {
  for (int i = 0; i < rows_; ++i) w[i] = -b_[at(i)];
  for (int i = 0; i < rows_; ++i) {
    if (x[i] != 0) subtract(-x[i], column(i), w, rows_);
  }
}

double MixedLcp::slack() const {
  return kOnBound * ConstValues(x_.data(), rows_).cwiseAbs().maxCoeff();
}

/// Goes from x to z as far as the bounds of free rows allow: at best to the point of the box that
/// is nearest to z, if that is downhill, or else straight until the first row meets its bound.
/// True when it got to z.
bool MixedLcp::advance() {
  const double slack = this->slack();
  bool inside = true;
  for (int i = 0; i < rows_; ++i) {
    y_[at(i)] = std::clamp(z_[at(i)], lo_[at(i)], hi_[at(i)]);
    inside = inside && std::abs(y_[at(i)] - z_[at(i)]) <= slack;
  }
  if (inside) {
    x_ = z_;
    find_w(x_.data(), w_.data());
    return true;
  }
  const int n = rows_;
  find_w(y_.data(), w_next_.data());
  const Values x(x_.data(), n), y(y_.data(), n), w(w_.data(), n), w_next(w_next_.data(), n);
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
    find_w(y_.data(), w_next_.data());
  }
  for (int i = 0; i < n; ++i) {
    if (where_[at(i)] != Where::kFree) continue;
    // The row that ends a straight way is at its bound, whatever rounding says.
    const double way = z_[at(i)] - x_[at(i)], bound = way < 0 ? lo_[at(i)] : hi_[at(i)];
    const bool ends = step < 1 && way != 0 && (bound - x_[at(i)]) / way <= step;
    if (ends) y_[at(i)] = bound;
    if (ends || y_[at(i)] != z_[at(i)]) settle(i, y_[at(i)]);
  }
  x_ = y_;
  w_ = w_next_;
  return false;
}

void MixedLcp::settle(int i, double x) {
  Where& where = where_[at(i)];
  if (lo_[at(i)] == hi_[at(i)]) {
    where = Where::kNever;
  } else if (x <= lo_[at(i)]) {
    where = Where::kLow;
  } else {
    where = x >= hi_[at(i)] ? Where::kHigh : Where::kFree;
  }
}

/// Frees rows that want to leave their bounds: all, or the one that wants most. False: none does.
bool MixedLcp::release(bool all) {
  double most = kStill;
  int worst = -1;
  for (int i = 0; i < rows_; ++i) {
    Where& where = where_[at(i)];
    if (where == Where::kFree || where == Where::kNever) continue;
    const double wish = where == Where::kLow ? -w_[at(i)] : w_[at(i)];
    if (wish <= kStill) continue;
    if (all) where = Where::kFree;
    if (wish > most) {
      most = wish;
      worst = i;
    }
  }
  if (worst >= 0) where_[at(worst)] = Where::kFree;
  return worst >= 0;
}

/// Block principal pivoting: moves all rows at once that are not where they belong. Quick, but it
/// may go round in circles; then x is as before.
bool MixedLcp::exchange() {
  y_ = x_;
  int fewest = rows_ + 1, chances = kChances;
  while (true) {
    for (int i = 0; i < rows_; ++i) {
      if (where_[at(i)] == Where::kLow || where_[at(i)] == Where::kNever) x_[at(i)] = lo_[at(i)];
      if (where_[at(i)] == Where::kHigh) x_[at(i)] = hi_[at(i)];
    }
    solve_free();
    x_ = z_;
    find_w(x_.data(), w_.data());
    const int moved = move_misplaced();
    if (moved == 0) return true;
    if (moved < fewest) {
      fewest = moved;
      chances = kChances;
    } else if (--chances == 0) {
      x_ = y_;
      return false;
    }
  }
}

int MixedLcp::move_misplaced() {
  const double slack = this->slack();
  int moved = 0;
  for (int i = 0; i < rows_; ++i) {
    Where& where = where_[at(i)];
    Where to = where;
    if (where == Where::kFree) {
      if (x_[at(i)] < lo_[at(i)] - slack) to = Where::kLow;
      if (x_[at(i)] > hi_[at(i)] + slack) to = Where::kHigh;
    } else if ((where == Where::kLow && w_[at(i)] < -kStill) ||
               (where == Where::kHigh && w_[at(i)] > kStill)) {
      to = Where::kFree;
    }
    moved += to != where;
    where = to;
  }
  return moved;
}

void MixedLcp::settle_all() {
  for (int i = 0; i < rows_; ++i) {
    x_[at(i)] = std::clamp(x_[at(i)], lo_[at(i)], hi_[at(i)]);
    settle(i, x_[at(i)]);
  }
}

/// Exactly for the present bounds, from the present x.
void MixedLcp::solve() {
  settle_all();
  if (!exchange()) descend();
}

/// Active sets, always downhill on x A x / 2 - b x, so it comes to an end.
bool MixedLcp::descend() {
  settle_all();
  find_w(x_.data(), w_.data());
  for (int round = 0; round < kMostRounds; ++round) {
    solve_free();
    if (advance() && !release(round < kManyAtOnce)) return true;
  }
  return false;
}

}  // namespace aprsim::physics
