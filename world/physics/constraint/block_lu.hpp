#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace aprsim::physics {

/// Solves sparse linear systems of 6 by 6 blocks, one row of blocks a body, with symmetric
/// structure: L U by blocks, eliminated in the order of least degree. Rows are exchanged within a
/// block only. No call allocates after warm-up; the same structure and numbers give the same bits.
///
/// Sources: Davis, Direct Methods for Sparse Linear Systems (2006); George & Liu 1989 for the
/// order.
class BlockLu {
 public:
  using Block = Eigen::Matrix<double, 6, 6>;
  using BlockVector = Eigen::Matrix<double, 6, 1>;

  /// The two blocks of a pair.
  struct PairBlocks {
    int block = -1;
    bool first_above = false;  ///< (first, second) is the upper one
  };

  /// Sets the structure: `count` bodies, and pairs of different ones that are coupled, in any order
  /// and number. The blocks become undefined.
  void analyse(int count, std::span<const std::pair<int, int>> pairs);
  /// Blocks of pair number `i`.
  [[nodiscard]] PairBlocks pair_blocks(std::size_t i) const { return pair_blocks_[i]; }

  void set_zero();
  /// Saves the blocks until the next save() or analyse().
  void save();
  /// Sets the saved blocks.
  void restore();
  [[nodiscard]] Block& diagonal(int i) { return blocks_[at(i)]; }
  /// The block (first, second) of a pair, and (second, first).
  [[nodiscard]] Block& forward(const PairBlocks& pair) {
    return (pair.first_above ? upper_ : blocks_)[at(pair.block)];
  }
  [[nodiscard]] Block& backward(const PairBlocks& pair) {
    return (pair.first_above ? blocks_ : upper_)[at(pair.block)];
  }

  /// In place. False if a pivot is singular.
  [[nodiscard]] bool factorise();
  /// One vector a body, in place. Only once after factorise(), for it overwrites the last blocks.
  /// False when one of these is singular.
  [[nodiscard]] bool solve(std::span<BlockVector> x);

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
  void list_updates();
  void connect(int a, int b);
  [[nodiscard]] int find_block(int row, int column) const;

  std::vector<Block> blocks_, upper_;  // diagonal ones by body, then those below and beside
  std::vector<Block> saved_blocks_, saved_upper_;
  std::vector<PairBlocks> pair_blocks_;
  std::vector<Column> columns_;  // in order of elimination
  std::vector<Row> rows_;
  std::vector<int> updates_;  // target block of each product of two rows of a column
  std::vector<int> rank_;     // by body, in the order of elimination
  std::vector<std::vector<int>> neighbours_;
  std::vector<char> eliminated_;
};

}  // namespace aprsim::physics
