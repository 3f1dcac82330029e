#include "world/physics/constraint/block_lu.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "world/base/simd/vector6.hpp"
#include "world/base/simd/vector_clones.hpp"

namespace aprsim::physics {
namespace {

using Block = BlockLu::Block;

// Elimination in order is left for exchanges of rows beyond these bounds: of a pivot's inverse,
// which must not overflow, and of a factor, by which rounding errors grow.
constexpr double kMaxPivotInverse = 1e200, kMaxFactor = 10;

/// The inner operations keep one 6-vector in two registers (four and two numbers), with a fixed
/// order of additions, so that every register width gives the same bits.
/// a = a b.
inline void multiply(Block& a, const Block& b) {
  const Matrix6 left = Matrix6::load(a);
  for (int j = 0; j < 6; ++j) left.times(b.col(j).data()).store(a.col(j).data());
}

/// out -= a b.
inline void subtract_product(const Block& a, const Block& b, Block& out) {
  const Matrix6 left = Matrix6::load(a);
  for (int j = 0; j < 6; ++j) {
    double* column = out.col(j).data();
    (Vector6::load(column) - left.times(b.col(j).data())).store(column);
  }
}

/// x -= a y.
inline void subtract_product(const Block& a, const BlockLu::BlockVector& y,
                             BlockLu::BlockVector& x) {
  (Vector6::load(x.data()) - Matrix6::load(a).times(y.data())).store(x.data());
}

/// Calls `step` with 0 to 5 as constants, as long as it returns true.
template <typename Step>
inline bool for_each_of_six(const Step& step) {
  return [&]<int... k>(std::integer_sequence<int, k...>) {
    return (step(std::integral_constant<int, k>{}) && ...);
  }
  (std::make_integer_sequence<int, 6>{});
}

/// Whether an exchange of rows would be better. `factors` of row k are subtracted from the others.
inline bool grows(const Vector6& factors, int k, double inverse) {
  bool in_order = std::abs(inverse) < kMaxPivotInverse;
  for (int i = k + 1; i < 6; ++i) in_order = in_order && std::abs(factors[i]) <= kMaxFactor;
  return !in_order;
}

/// Golub & Van Loan, Matrix Computations (4th ed.), sec. 3.4: pivoting bounds the growth of the
/// multipliers. Here the diagonal is tried first, since M + J' G J is close to symmetric positive
/// definite, and exchanges are only used where a bound fails.
/// Gauss-Jordan without exchanges of rows. False, with m unchanged, where they are needed.
inline bool invert_in_order(Block& m) {
  Matrix6 c = Matrix6::load(m);
  const auto eliminate = [&c](auto step) {
    constexpr int k = decltype(step)::value;
    const double inverse = 1 / c.column[k][k];
    Vector6 factors = inverse * c.column[k];
    if (grows(factors, k, inverse)) return false;
    // Masks replace the row k by its part of the inverse, without a branch per element.
    const Vector6 own = Vector6::unit(k), others = Vector6::one() - own;
    factors = factors * others - inverse * own;
    for (int j = 0; j < 6; ++j) {
      if (j != k) c.column[j] = c.column[j] * others - c.column[j][k] * factors;
    }
    c.column[k] = -1 * factors;
    return true;
  };
  if (!for_each_of_six(eliminate)) return false;
  c.store(m);
  return true;
}

/// A right-hand side needs half of the operations of an inverse: the columns left of the pivot are
/// never read again.
/// x = m^-1 x by Gauss-Jordan without exchanges of rows. False, with x unchanged, where they are
/// needed.
inline bool solve_in_order(const Block& m, BlockLu::BlockVector& x) {
  Matrix6 c = Matrix6::load(m);
  Vector6 y = Vector6::load(x.data());
  double inverses[6];
  const auto eliminate = [&](auto step) {
    constexpr int k = decltype(step)::value;
    inverses[k] = 1 / c.column[k][k];
    Vector6 factors = inverses[k] * c.column[k];
    if (grows(factors, k, inverses[k])) return false;
    factors = factors * (Vector6::one() - Vector6::unit(k));
    for (int j = k + 1; j < 6; ++j) c.column[j] = c.column[j] - c.column[j][k] * factors;
    y = y - y[k] * factors;
    return true;
  };
  if (!for_each_of_six(eliminate)) return false;
  for (int k = 0; k < 6; ++k) x(k) = y[k] * inverses[k];
  return true;
}

/// Partial pivoting, for blocks that elimination in order would solve too inaccurately.
/// Gauss-Jordan with exchanges of rows. False for a singular one.
bool invert_with_exchanges(Block& m) {
  std::array<int, 6> exchanged;
  for (int k = 0; k < 6; ++k) {
    int pivot = k;
    for (int i = k + 1; i < 6; ++i) {
      if (std::abs(m(i, k)) > std::abs(m(pivot, k))) pivot = i;
    }
    exchanged[static_cast<std::size_t>(k)] = pivot;
    if (pivot != k) {
      for (int j = 0; j < 6; ++j) std::swap(m(k, j), m(pivot, j));
    }
    if (!(std::abs(m(k, k)) > 0)) return false;
    const double inverse = 1 / m(k, k);
    m(k, k) = 1;
    for (int j = 0; j < 6; ++j) m(k, j) *= inverse;
    double factor[6];
    for (int i = 0; i < 6; ++i) {
      factor[i] = i == k ? 0 : m(i, k);
      if (i != k) m(i, k) = 0;
    }
    for (int j = 0; j < 6; ++j) {
      const double of_row = m(k, j);
      for (int i = 0; i < 6; ++i) m(i, j) -= factor[i] * of_row;
    }
  }
  // The inverse of P A is A^-1 P', so the columns are exchanged back in reverse order.
  for (int k = 5; k >= 0; --k) {
    const int pivot = exchanged[static_cast<std::size_t>(k)];
    if (pivot == k) continue;
    for (int i = 0; i < 6; ++i) std::swap(m(i, k), m(i, pivot));
  }
  return true;
}

inline bool invert(Block& m) { return invert_in_order(m) || invert_with_exchanges(m); }

/// x = m^-1 x; may overwrite m. False for a singular one.
inline bool solve_one(Block& m, BlockLu::BlockVector& x) {
  if (solve_in_order(m, x)) return true;
  if (!invert_with_exchanges(m)) return false;
  x = m * BlockLu::BlockVector(x);
  return true;
}

/// Inserts into a sorted list of different numbers.
void insert_sorted(std::vector<int>& list, int value) {
  const auto place = std::lower_bound(list.begin(), list.end(), value);
  if (place == list.end() || *place != value) list.insert(place, value);
}

}  // namespace

void BlockLu::connect(int a, int b) {
  insert_sorted(neighbours_[at(a)], b);
  insert_sorted(neighbours_[at(b)], a);
}

void BlockLu::analyse(int count, std::span<const std::pair<int, int>> pairs) {
  if (neighbours_.size() < at(count)) neighbours_.resize(at(count));
  for (int i = 0; i < count; ++i) neighbours_[at(i)].clear();
  for (const auto& [a, b] : pairs) connect(a, b);
  choose_order(count);
  pair_blocks_.clear();
  for (const auto& [a, b] : pairs) {
    // A pair may be named in either direction; the stored orientation follows the order of
    // elimination.
    const bool above = rank_[at(a)] < rank_[at(b)];  // the lower block's row is the later body
    pair_blocks_.push_back({above ? find_block(b, a) : find_block(a, b), above});
  }
}

/// Minimum degree, greedily: the body with the fewest neighbours is eliminated next, and couples
/// these with each other (fill-in).
void BlockLu::choose_order(int count) {
  columns_.clear();
  rows_.clear();
  updates_.clear();
  rank_.assign(at(count), 0);
  eliminated_.assign(at(count), 0);
  int blocks = count;
  for (int rank = 0; rank < count; ++rank) {
    int best = -1;
    for (int i = 0; i < count; ++i) {
      if (eliminated_[at(i)]) continue;
      if (best < 0 || neighbours_[at(i)].size() < neighbours_[at(best)].size()) best = i;
    }
    eliminated_[at(best)] = 1;
    rank_[at(best)] = rank;
    Column column{
        .body = best, .first = static_cast<int>(rows_.size()), .count = 0, .first_update = 0};
    const std::vector<int>& left = neighbours_[at(best)];
    // Every remaining neighbour gets a block below the pivot. Blocks of L and of U share one index.
    for (const int i : left) rows_.push_back({i, blocks++});
    column.count = static_cast<int>(left.size());
    columns_.push_back(column);
    // Elimination graph (George & Liu 1989): the neighbours of an eliminated node form a
    // clique.
    for (std::size_t i = 0; i < left.size(); ++i) {
      auto& other = neighbours_[at(left[i])];
      other.erase(std::lower_bound(other.begin(), other.end(), best));
      for (std::size_t k = 0; k < i; ++k) connect(left[i], left[k]);
    }
  }
  blocks_.resize(at(blocks));
  upper_.resize(at(blocks));
  list_updates();
}

/// The target of each product of two rows of a column. Rows are sorted in order of elimination, so
/// that a product's later body is its row.
void BlockLu::list_updates() {
  for (Column& column : columns_) {
    const auto first = rows_.begin() + column.first;
    std::sort(first, first + column.count,
              [this](const Row& a, const Row& b) { return rank_[at(a.body)] < rank_[at(b.body)]; });
  }
  for (Column& column : columns_) {
    column.first_update = static_cast<int>(updates_.size());
    for (int i = 0; i < column.count; ++i) {
      const int row = rows_[at(column.first + i)].body;
      for (int k = 0; k <= i; ++k) {
        updates_.push_back(find_block(row, rows_[at(column.first + k)].body));
      }
    }
  }
}

int BlockLu::find_block(int row, int column) const {
  if (row == column) return row;
  const Column& in = columns_[at(rank_[at(column)])];
  for (int i = 0; i < in.count; ++i) {
    if (rows_[at(in.first + i)].body == row) return rows_[at(in.first + i)].block;
  }
  return -1;
}

void BlockLu::set_zero() {
  for (Block& block : blocks_) block.setZero();
  for (Block& block : upper_) block.setZero();
}

void BlockLu::save() {
  saved_blocks_ = blocks_;
  saved_upper_ = upper_;
}

void BlockLu::restore() {
  blocks_ = saved_blocks_;
  upper_ = saved_upper_;
}

/// Right-looking: each finished column is subtracted from the remaining matrix. L stores
/// A_ij A_jj^-1, and U its rows unscaled.
APRSIM_VECTOR_CLONES bool BlockLu::factorise() {
  for (const Column& column : columns_) {
    if (column.count == 0) continue;  // the last one of a connected part: see solve()
    Block& pivot = blocks_[at(column.body)];
    if (!invert(pivot)) return false;
    for (int i = 0; i < column.count; ++i) {
      multiply(blocks_[at(rows_[at(column.first + i)].block)], pivot);
    }
    // Schur complement: A_ij -= L_ik U_kj for all pairs of rows of this column. Both triangles are
    // needed, because the De Saxce correction makes the matrix unsymmetric.
    int update = column.first_update;
    for (int i = 0; i < column.count; ++i) {
      const std::size_t a = at(rows_[at(column.first + i)].block);
      for (int k = 0; k < i; ++k) {
        const std::size_t b = at(rows_[at(column.first + k)].block);
        const std::size_t target = at(updates_[at(update++)]);
        subtract_product(blocks_[a], upper_[b], blocks_[target]);
        subtract_product(blocks_[b], upper_[a], upper_[target]);
      }
      subtract_product(blocks_[a], upper_[a], blocks_[at(updates_[at(update++)])]);
    }
  }
  return true;
}

APRSIM_VECTOR_CLONES bool BlockLu::solve(std::span<BlockVector> x) {
  // Forward substitution with the unit lower factor, in the order of elimination.
  for (const Column& column : columns_) {
    const BlockVector& own = x[at(column.body)];
    for (int i = 0; i < column.count; ++i) {
      const Row& row = rows_[at(column.first + i)];
      subtract_product(blocks_[at(row.block)], own, x[at(row.body)]);
    }
  }
  // Back substitution. The pivots are stored inverted; the last one of each component is solved
  // directly, which saves an inversion per island.
  for (std::size_t c = columns_.size(); c-- > 0;) {
    const Column& column = columns_[c];
    if (column.count == 0) {
      if (!solve_one(blocks_[at(column.body)], x[at(column.body)])) return false;
      continue;
    }
    BlockVector& own = x[at(column.body)];
    for (int i = 0; i < column.count; ++i) {
      const Row& row = rows_[at(column.first + i)];
      subtract_product(upper_[at(row.block)], x[at(row.body)], own);
    }
    Matrix6::load(blocks_[at(column.body)]).times(own.data()).store(own.data());
  }
  return true;
}

}  // namespace aprsim::physics
