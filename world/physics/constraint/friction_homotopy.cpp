#include <algorithm>
#include <cmath>
#include <limits>

#include "world/physics/constraint/cholesky.hpp"
#include "world/physics/constraint/mixed_lcp.hpp"

// From a solution for fixed bounds of friction to one for bounds that follow the normals. With
// `left` of the bounds' error still there, a bound is mu x_normal + left error, or zero when that
// is negative. As long as no row changes its place, x and w are linear in `left`. Where the next
// row does, it is moved and the line goes on on the other side, if need be backwards in `left` (as
// in Lemke's method), until nothing is left.
namespace aprsim::physics {
namespace {

constexpr double kNoError = 1e-12;  // of the bound
constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

void MixedLcp::note_errors() {
  for (int i = 0; i < rows_; ++i) {
    const Row& row = row_[at(i)];
    double& error = error_[at(i)];
    error = 0;
    if (row.normal < 0) continue;
    error = hi_[at(i)] - row.mu * std::max(0.0, x_[at(row.normal)]);
    if (std::abs(error) <= kNoError * hi_[at(i)]) error = 0;
  }
}

double MixedLcp::bound_end(int i) const {
  return row_[at(i)].mu * x_line_.end[at(row_[at(i)].normal)];
}

double MixedLcp::bound_slope(int i) const {
  return row_[at(i)].mu * x_line_.slope[at(row_[at(i)].normal)] + error_[at(i)];
}

/// The equations of the free rows; those of friction at their bounds move with their normals, so
/// their columns are part of these. Returns the number of free rows.
int MixedLcp::gather_piece(Numbers& right, Numbers& slope) {
  const int n = rows_, count = list_free();
  std::copy_n(b_.data(), n, right.data());
  std::fill_n(slope.data(), n, 0.0);
  for (int k = 0; k < count; ++k) {
    const double* from = column(free_[at(k)]);
    double* to = factor_.data() + at(k) * kCapacity;
    for (int m = 0; m < count; ++m) to[m] = from[free_[at(m)]];
  }
  for (int i = 0; i < n; ++i) {
    const Row& row = row_[at(i)];
    const Where where = where_[at(i)];
    x_line_.end[at(i)] = x_line_.slope[at(i)] = 0;
    if (where == Where::kFree || where == Where::kNever) continue;
    if (row.normal < 0) {
      const double x = where == Where::kLow ? row.lo : row.hi;
      x_line_.end[at(i)] = x;
      if (x != 0) subtract(x, column(i), right.data(), n);
      continue;
    }
    if (error_[at(i)] != 0) subtract(sign(i) * error_[at(i)], column(i), slope.data(), n);
    const int k = place_[at(row.normal)];
    if (k < 0) continue;
    const double* from = column(i);
    double* to = factor_.data() + at(k) * kCapacity;
    for (int m = 0; m < count; ++m) to[m] += sign(i) * row.mu * from[free_[at(m)]];
  }
  return count;
}

/// x and w on the present piece; false when they are not determined.
bool MixedLcp::find_piece() {
  const int n = rows_;
  const int count = gather_piece(y_, z_);
  Numbers right, slope;
  for (int k = 0; k < count; ++k) {
    right[at(k)] = y_[at(free_[at(k)])];
    slope[at(k)] = z_[at(free_[at(k)])];
  }
  if (!solve_two(factor_.data(), count, kCapacity, right.data(), slope.data())) return false;
  for (int k = 0; k < count; ++k) {
    x_line_.end[at(free_[at(k)])] = right[at(k)];
    x_line_.slope[at(free_[at(k)])] = slope[at(k)];
  }
  for (int i = 0; i < n; ++i) {
    if (row_[at(i)].normal < 0) continue;
    if (where_[at(i)] != Where::kLow && where_[at(i)] != Where::kHigh) continue;
    x_line_.end[at(i)] = sign(i) * bound_end(i);
    x_line_.slope[at(i)] = sign(i) * bound_slope(i);
  }
  find_w(x_line_.end.data(), w_line_.end.data());
  std::fill_n(w_line_.slope.data(), n, 0.0);
  for (int i = 0; i < n; ++i) {
    const double x = x_line_.slope[at(i)];
    if (x != 0) subtract(-x, column(i), w_line_.slope.data(), n);
  }
  return true;
}

/// The direction in `left` that takes the row that has just changed further into its new place.
double MixedLcp::way_on(const Change& last) const {
  const int i = last.row;
  const bool friction = row_[at(i)].normal >= 0;
  const double x = x_line_.slope[at(i)], w = w_line_.slope[at(i)];
  if (last.to == Where::kNever) return -bound_slope(i);
  if (last.from == Where::kNever) return bound_slope(i);
  if (last.to == Where::kLow) return w;
  if (last.to == Where::kHigh) return -w;
  const double bound = friction ? bound_slope(i) : 0;
  return last.from == Where::kLow ? x + bound : bound - x;
}

/// Where a row of friction goes that is allowed a force again.
MixedLcp::Where MixedLcp::pushed(int i, double left) const {
  return w_line_.at(i, left) > 0 ? Where::kLow : Where::kHigh;
}

/// The first row that leaves its place on the way from `left` on.
MixedLcp::Change MixedLcp::next_change(double left, double direction, const Change& last) const {
  Change next{.distance = direction < 0 ? left : kNever};
  const auto meet = [&](int i, double end, double slope, Where to) {
    const double falls = -direction * slope;
    if (falls <= 0 || (i == last.row && to == last.from)) return;
    const double distance = std::max(0.0, (end + left * slope) / falls);
    if (distance < next.distance) next = {i, where_[at(i)], to, distance};
  };
  for (int i = 0; i < rows_; ++i) {
    const Row& row = row_[at(i)];
    const Where where = where_[at(i)];
    const bool friction = row.normal >= 0;
    if (friction ? row.mu == 0 : row.lo == row.hi) continue;
    const double x = x_line_.end[at(i)], dx = x_line_.slope[at(i)];
    const double w = w_line_.end[at(i)], dw = w_line_.slope[at(i)];
    const double bound = friction ? bound_end(i) : 0, dbound = friction ? bound_slope(i) : 0;
    if (where == Where::kFree) {
      meet(i, friction ? x + bound : x - row.lo, dx + dbound, Where::kLow);
      if (friction || row.hi < kNever) {
        meet(i, friction ? bound - x : row.hi - x, dbound - dx, Where::kHigh);
      }
    } else if (where == Where::kNever) {
      if (error_[at(i)] != 0) meet(i, -bound, -dbound, pushed(i, left));
    } else {
      meet(i, -sign(i) * w, -sign(i) * dw, Where::kFree);
      if (friction && error_[at(i)] != 0) meet(i, bound, dbound, Where::kNever);
    }
  }
  return next;
}

/// The two rows of friction of a contact get and lose their bound together; without an error of
/// their own they do so with their normal.
void MixedLcp::make(const Change& change, double left) {
  const int normal = row_[at(change.row)].normal;
  where_[at(change.row)] = change.to;
  const bool of_bound = change.from == Where::kNever || change.to == Where::kNever;
  if (normal >= 0 && !of_bound) return;
  for (int i = 0; i < rows_; ++i) {
    const Row& row = row_[at(i)];
    if (i == change.row || row.normal < 0 || row.mu == 0) continue;
    if (normal >= 0 && row.normal == normal) {
      where_[at(i)] = change.to == Where::kNever ? Where::kNever : pushed(i, left);
    } else if (row.normal == change.row && error_[at(i)] == 0) {
      where_[at(i)] = change.to == Where::kFree ? pushed(i, left) : Where::kNever;
    }
  }
}

bool MixedLcp::follow(int most_changes) {
  note_errors();
  double left = 1, direction = -1;
  Change last;
  for (int changes = 0; changes <= most_changes; ++changes) {
    if (!find_piece()) return false;
    if (last.row >= 0) {
      const double way = way_on(last);
      if (way == 0) return false;
      direction = way > 0 ? 1 : -1;
    }
    const Change next = next_change(left, direction, last);
    if (next.row < 0) {
      if (direction < 0) x_ = x_line_.end;
      return direction < 0;
    }
    left += direction * next.distance;
    make(next, left);
    last = next;
  }
  return false;
}

}  // namespace aprsim::physics
