#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace aprsim::physics {

/// A x = b + w with lo <= x <= hi, where w is zero for x between its bounds, not negative at the
/// lower and not positive at the upper one: what limited impulses do to the velocities they act
/// along. A is symmetric and positive definite. Contacts are three rows: a normal one and two of
/// friction, whose bounds are mu times the normal's x. No call allocates.
class MixedLcp {
 public:
  static constexpr int kCapacity = 192;

  struct Row {
    double lo = 0, hi = 0;
    int normal = -1;  ///< of a friction row: the row of its normal
    double mu = 0;
  };

  void clear() { rows_ = 0; }
  /// Adds a row, its part of A to be filled in; the search starts at `guess`.
  int add(const Row& row, double guess = 0);
  [[nodiscard]] int rows() const { return rows_; }
  /// Column of A; symmetric, so both halves are to be set.
  [[nodiscard]] double* column(int i) { return a_.data() + at(i) * kCapacity; }
  [[nodiscard]] double& b(int i) { return b_[at(i)]; }
  [[nodiscard]] double x(int i) const { return x_[at(i)]; }

  /// Friction and normals together. Relaxation (Gauss-Seidel, at most `most_rounds`)
  /// guesses the normals; for the bounds of friction that these give everything is solved exactly;
  /// then what the bounds are off from the normals found is taken away bit by bit, and the solution
  /// followed exactly from one change of a row's place to the next, at most `most_changes`. False
  /// when the way is longer, or has no end (there may be no solution near by, or several): then x
  /// is as before it.
  bool solve_together(int most_rounds, int most_changes);
  /// First without friction, then exactly with the bounds that follow: right where friction does
  /// not change the normals.
  void solve_one_after_the_other();

 private:
  using Numbers = std::array<double, kCapacity>;
  enum class Where : char { kFree, kLow, kHigh, kNever };
  /// Numbers that change evenly with what is left of the error of the bounds, which starts at 1.
  struct Line {
    Numbers end, slope;  ///< at 0; by what is left
    [[nodiscard]] double at(int i, double left) const {
      return end[static_cast<std::size_t>(i)] + left * slope[static_cast<std::size_t>(i)];
    }
  };
  struct Change {
    int row = -1;
    Where from = Where::kFree, to = Where::kFree;
    double distance = 0;  ///< in what is left
  };
  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] const double* column(int i) const { return a_.data() + at(i) * kCapacity; }
  void relax(int most);
  void fix_friction();
  void solve();
  int list_free();
  void find_w(const double* x, double* w) const;
  [[nodiscard]] double slack() const;
  void settle_all();
  bool exchange();
  int move_misplaced();
  bool descend();
  void solve_free();
  bool advance();
  void settle(int i, double x);
  bool release(bool all);

  bool follow(int most_changes);
  void note_errors();
  bool find_piece();
  int gather_piece(Numbers& right, Numbers& slope);
  [[nodiscard]] double sign(int i) const { return where_[at(i)] == Where::kLow ? -1 : 1; }
  [[nodiscard]] double bound_end(int i) const;
  [[nodiscard]] double bound_slope(int i) const;
  [[nodiscard]] double way_on(const Change& last) const;
  [[nodiscard]] Change next_change(double left, double direction, const Change& last) const;
  void make(const Change& change, double left);
  [[nodiscard]] Where pushed(int i, double left) const;

  int rows_ = 0;
  std::array<Row, kCapacity> row_;
  Numbers b_{}, x_{}, w_{}, lo_{}, hi_{}, y_{}, z_{}, w_next_{};
  std::array<Where, kCapacity> where_{};
  std::array<int, kCapacity> free_{}, place_{};  // free rows; their places in that list, or -1
  Numbers error_{};                              // of a bound of friction before it is followed
  Line x_line_{}, w_line_{};
  std::vector<double> a_ = std::vector<double>(kCapacity * kCapacity);
  std::vector<double> factor_ = std::vector<double>(kCapacity * kCapacity);
};

}  // namespace aprsim::physics
