#pragma once

#include "world/physics/constraint/mixed_lcp.hpp"

namespace aprsim::physics {

/// From a solution for fixed bounds of friction to one whose bounds follow the normals found with
/// it, by continuation. With residual r of the bounds' error, a bound is mu x_normal + r error, or
/// zero where that is negative; r = 1 is the solution at hand, r = 0 the one looked for. While no
/// row changes its state x and w are linear in r. Where the next row does, it changes, and the path
/// goes on along the next piece, if need be backwards in r.
///
/// Source: complementary pivoting along a parameter, as in Lemke (1965); pieces of the path are
/// solved anew instead of a tableau being updated. No call allocates.
class FrictionHomotopy {
 public:
  /// Replaces the solution of `lcp`. False when the path has more than `most_changes` changes of
  /// state or does not go on (there may be no solution near by, or several): `lcp` is as before.
  bool continue_friction(MixedLcp& lcp, int most_changes);

 private:
  using Numbers = MixedLcp::Numbers;
  using Row = MixedLcp::Row;
  using RowState = MixedLcp::RowState;
  /// Numbers that are linear in the residual.
  struct Line {
    Numbers end, slope;  ///< at residual 0; by residual
    [[nodiscard]] double at(int i, double residual) const {
      return end[static_cast<std::size_t>(i)] + residual * slope[static_cast<std::size_t>(i)];
    }
  };
  struct Change {
    int row = -1;
    RowState from = RowState::kFree, to = RowState::kFree;
    double distance = 0;  ///< in the residual
  };

  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] const Row& row(int i) const { return lcp_->row(i); }
  [[nodiscard]] double sign(int i) const { return state_[at(i)] == RowState::kLow ? -1 : 1; }
  void find_errors();
  int list_free();
  bool find_piece();
  int gather_equations(Numbers& right, Numbers& slope);
  [[nodiscard]] double bound_end(int i) const;
  [[nodiscard]] double bound_slope(int i) const;
  [[nodiscard]] double direction_after(const Change& last) const;
  [[nodiscard]] Change next_change(double residual, double direction, const Change& last) const;
  void apply(const Change& change, double residual);
  [[nodiscard]] RowState state_when_unlocked(int i, double residual) const;

  const MixedLcp* lcp_ = nullptr;  // of the call at hand
  int rows_ = 0;
  MixedLcp::RowStates state_{};
  std::array<int, MixedLcp::kCapacity> free_{}, place_{};  // free rows; places in that list, or -1
  Numbers error_{};                                        // of a friction bound at the start
  Line x_{}, w_{};
  Numbers right_{}, slope_{};
  std::vector<double> factor_ =
      std::vector<double>(std::size_t{MixedLcp::kCapacity} * MixedLcp::kCapacity);
};

}  // namespace aprsim::physics
