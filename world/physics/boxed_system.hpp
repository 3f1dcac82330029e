#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace aprsim::physics {

/// A x = b + w with lo <= x <= hi, where w is zero for x between its bounds, not negative at the
/// lower and not positive at the upper one: what limited impulses do to the velocities they act
/// along. A is symmetric and positive definite. Contacts are three rows: a normal one and two of
/// friction, whose bounds are mu times the normal's x. No call allocates.
class BoxedSystem {
 public:
  static constexpr int kCapacity = 192;

  struct Row {
    double lo = 0, hi = 0;
    int normal = -1;  ///< of a friction row: the row of its normal
    double mu = 0;
  };

  void clear() { rows_ = 0; }
  /// Adds a row, its part of A to be filled in.
  int add(const Row& row);
  [[nodiscard]] int rows() const { return rows_; }
  /// Column of A; symmetric, so both halves are to be set.
  [[nodiscard]] double* column(int i) { return a_.data() + at(i) * kCapacity; }
  [[nodiscard]] double& b(int i) { return b_[at(i)]; }
  [[nodiscard]] double x(int i) const { return x_[at(i)]; }

  /// Friction and normals together: first by relaxation from zero, in which the bounds of friction
  /// follow the normals, at most `most_rounds`; then exactly for those bounds; then again for the
  /// bounds that follow from the normals found, as long as these come closer to each other, until
  /// they differ by no more than `enough`. From relaxation alone normals are too far off when
  /// something light is hit between heavy things; corrected normals alone may jam what does not.
  void solve_together(int most_rounds, int most_corrections, double enough);
  /// First without friction, then exactly with the bounds that follow: right where friction does
  /// not change the normals.
  void solve_one_after_the_other();

 private:
  using Numbers = std::array<double, kCapacity>;
  enum class Where : char { kFree, kLow, kHigh, kNever };
  struct Solution {
    Numbers x, lo, hi;
    std::array<Where, kCapacity> where;
  };
  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] const double* column(int i) const { return a_.data() + at(i) * kCapacity; }
  [[nodiscard]] Solution solution() const;
  void go_back(const Solution& to);
  void relax(int most);
  double fix_friction();
  bool solve();
  bool solve_again();
  [[nodiscard]] double slack() const;
  void find_w(const double* x, double* w) const;
  void settle_all();
  bool exchange();
  int move_misplaced();
  bool descend();
  void solve_free();
  bool advance();
  void settle(int i, double x);
  bool release(bool all);

  int rows_ = 0;
  std::array<Row, kCapacity> row_;
  Numbers b_{}, x_{}, w_{}, lo_{}, hi_{}, y_{}, z_{}, w_next_{};
  std::array<Where, kCapacity> where_{};
  std::array<int, kCapacity> free_{};
  std::vector<double> a_ = std::vector<double>(kCapacity * kCapacity);
  std::vector<double> factor_ = std::vector<double>(kCapacity * kCapacity);
};

/// Lower triangle L of a = L L^T in place, columns `stride` apart, and solutions with it.
void factorise(double* a, int n, int stride);
void solve_lower(const double* l, int n, int stride, double* x);
void solve_lower_transposed(const double* l, int n, int stride, double* x);

}  // namespace aprsim::physics
