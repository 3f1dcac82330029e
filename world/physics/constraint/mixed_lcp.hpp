#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace aprsim::physics {

/// Mixed linear complementarity problem with bounds: A x = b + w with lo <= x <= hi, where w is
/// zero for x between its bounds, not negative at the lower and not positive at the upper one. x
/// are impulses, w the velocities along them that remain. A is symmetric and positive definite.
/// Contacts are three rows: a normal one and two of friction, whose bounds are mu times the
/// normal's x (friction pyramid). No call allocates.
///
/// Sources: Cottle, Pang & Stone, The Linear Complementarity Problem (1992); block principal
/// pivoting after Judice & Pires (1994); projected Gauss-Seidel for the estimate.
class MixedLcp {
 public:
  static constexpr int kCapacity = 192;
  using Numbers = std::array<double, kCapacity>;

  struct Row {
    double lo = 0, hi = 0;
    int normal = -1;  ///< of a friction row: the row of its normal
    double mu = 0;
  };
  /// Between its bounds, at one of them, or without room between them.
  enum class RowState : char { kFree, kLow, kHigh, kLocked };
  using RowStates = std::array<RowState, kCapacity>;

  void clear() { rows_ = 0; }
  /// Adds a row, its part of A to be filled in; the search starts at `guess`. Throws
  /// std::length_error beyond kCapacity.
  int add(const Row& row, double guess = 0);
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] const Row& row(int i) const { return row_[at(i)]; }
  /// Column of A; symmetric, so both halves are to be set.
  [[nodiscard]] double* column(int i) { return a_.data() + at(i) * kCapacity; }
  [[nodiscard]] const double* column(int i) const { return a_.data() + at(i) * kCapacity; }
  [[nodiscard]] double& b(int i) { return b_[at(i)]; }

  /// With friction bounds from normals that projected Gauss-Seidel estimates (at most `most_rounds`
  /// sweeps); exact for these bounds. FrictionHomotopy goes on from here. False: given up, as near
  /// to the solution as it got.
  bool solve_estimated(int most_rounds);
  /// First without friction, then exactly with the bounds that follow: right where friction does
  /// not change the normals. False as above.
  bool solve_decoupled();

  // ---- the solution
  [[nodiscard]] double x(int i) const { return x_[at(i)]; }
  void set_x(const Numbers& x) { x_ = x; }
  [[nodiscard]] const Numbers& b() const { return b_; }
  /// Upper bound that the solution was found with.
  [[nodiscard]] double upper_bound(int i) const { return hi_[at(i)]; }
  [[nodiscard]] const RowStates& states() const { return state_; }
  /// w = A x - b.
  void find_w(const Numbers& x, Numbers& w) const;

 private:
  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  void relax(int most_rounds);
  void fix_friction_bounds();
  bool solve_for_bounds();
  int list_free();
  [[nodiscard]] double slack() const;
  void project();
  bool pivot_blocks();
  int exchange_misplaced();
  bool solve_active_set();
  void solve_free();
  bool step_to_free_solution();
  void set_state(int i, double x);
  bool release(bool all);

  int rows_ = 0;
  std::array<Row, kCapacity> row_;
  Numbers b_{}, x_{}, w_{}, lo_{}, hi_{}, y_{}, z_{}, w_next_{};
  RowStates state_{};
  std::array<int, kCapacity> free_{};  // the free rows
  std::vector<double> a_ = std::vector<double>(std::size_t{kCapacity} * kCapacity);
  std::vector<double> factor_ = std::vector<double>(std::size_t{kCapacity} * kCapacity);
};

}  // namespace aprsim::physics
