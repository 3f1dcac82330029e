#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace aprsim::physics {

/// Sparse linear systems whose unknowns come in sixes, one block for each body, with a symmetric
/// structure: L U by blocks, eliminated in the order of least degree, exchanges of rows only within
/// a block. No call allocates after warm-up; the same structure and numbers give the same bits.
///
/// Sources: Davis, Direct Methods for Sparse Linear Systems (2006); George & Liu 1989 for the
/// order.
class BlockLu {
 public:
  using Block = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  /// Where the two blocks of a pair stand.
  struct Place {
    int block = -1;
    bool first_above = false;  ///< (first, second) is the upper one
  };

  /// The structure: `count` bodies, and pairs of two different ones that are coupled, in any order
  /// and number. Forgets the numbers.
  void analyse(int count, std::span<const std::pair<int, int>> pairs);
  /// Of pair number `i`.
  [[nodiscard]] Place place(std::size_t i) const { return places_[i]; }

  void set_zero();
  /// Remembers the numbers as they are; forgotten by analyse().
  void keep();
  /// What was kept.
  void restore();
  [[nodiscard]] Block& diagonal(int i) { return blocks_[at(i)]; }
  /// The block (first, second) of a pair, and (second, first).
  [[nodiscard]] Block& forward(const Place& place) {
    return (place.first_above ? upper_ : blocks_)[at(place.block)];
  }
  [[nodiscard]] Block& backward(const Place& place) {
    return (place.first_above ? blocks_ : upper_)[at(place.block)];
  }

  /// In place. False when a pivot is singular.
  [[nodiscard]] bool factorise();
  /// Once after factorise(), for the last blocks are used up: one vector a body, in place. False
  /// when one of these is singular.
  [[nodiscard]] bool solve(std::span<Vector6> x);

 private:
  struct Column {
    int body = 0;
    int first = 0, count = 0;  // of the rows below
    int first_update = 0;      // of its outer products
  };
  struct Row {
    int body = 0, block = 0;
  };
  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  void choose_order(int count);
  void connect(int a, int b);
  [[nodiscard]] int find_block(int row, int column) const;

  std::vector<Block> blocks_, upper_;  // diagonal ones by body, then those below and beside
  std::vector<Block> kept_blocks_, kept_upper_;
  std::vector<Place> places_;
  std::vector<Column> columns_;  // in order of elimination
  std::vector<Row> rows_;
  std::vector<int> updates_;  // target block of each product of two rows of a column
  std::vector<int> turn_;     // of each body in that order
  std::vector<std::vector<int>> near_;
  std::vector<char> eliminated_;
};

}  // namespace aprsim::physics
