#include "world/physics/constraint/newton_matrix.hpp"

#include "world/base/simd/vector6.hpp"
#include "world/base/simd/vector_clones.hpp"

namespace aprsim::physics {
namespace {

using Block = BlockLu::Block;
using BlockVector = BlockLu::BlockVector;

/// Adds the blocks of contacts whose J' G J is S about the centre of a. With T = (1, -[d]; 0, 1),
/// which moves moments to the centre of b by d, they are -S T, -T' S and T' S T.
inline void add_shifted(const Matrix6& S, const Eigen::Vector3d& d, Block& forward, Block& backward,
                        Block& other) {
  // Shift of a spatial force between two points (Featherstone 2008, sec. 2.8). One product J' G J
  // per pair thus serves all four blocks.
  // T' times a column: d x its upper half is added to the lower one.
  const auto moved = [&d](const Vector6& column) {
    Vector6 out = column;
    out.head[3] += d.y() * column[2] - d.z() * column[1];
    out.tail +=
        Vector6::Pair{d.z() * column[0] - d.x() * column[2], d.x() * column[1] - d.y() * column[0]};
    return out;
  };
  for (int j = 0; j < 6; ++j) {
    // Column j of S T.
    Vector6 shifted = S.column[j];
    if (j >= 3) {
      const int u = (j - 2) % 3, v = (j - 1) % 3;  // the next two axes, cyclically
      shifted = shifted + (d(u) * S.column[v] - d(v) * S.column[u]);
    }
    add_column(-1 * shifted, forward, j);
    add_column(-1 * moved(S.column[j]), backward, j);
    add_column(moved(shifted), other, j);
  }
}

/// Adds a b'.
inline void add_outer(const BlockVector& a, const BlockVector& b, Block& out) {
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) out(i, j) += a(i) * b(j);
  }
}

}  // namespace

void NewtonMatrix::analyse(ContactProblem& problem) {
  pairs_.clear();
  // Rows and packs of the same two bodies in a row share one pair of blocks.
  // Kinematic bodies have no unknowns: their contacts contribute to the diagonal of the other body
  // only.
  std::pair<int, int> last(-1, -1);
  const auto pair_of = [&](int a, int b) {
    const int i = problem.unknown_of(a), k = problem.unknown_of(b);
    if (i < 0 || k < 0 || i == k) return -1;
    if (std::pair(i, k) != last || pairs_.empty()) pairs_.emplace_back(i, k);
    last = {i, k};
    return static_cast<int>(pairs_.size()) - 1;
  };
  for (SolverRow& row : problem.rows()) row.pair = pair_of(row.a.body, row.b.body);
  for (ContactPack& pack : problem.packs()) pack.pair = pair_of(pack.a, pack.b);
  lu_.analyse(static_cast<int>(problem.moving().size()), pairs_);
  rows_saved_ = false;
}

APRSIM_VECTOR_CLONES void NewtonMatrix::assemble(ContactProblem& problem) {
  assemble_rows(problem);
  assemble_contacts(problem);
}

void NewtonMatrix::assemble_rows(ContactProblem& problem) {
  // Where no row has reached or left a bound, nothing has changed.
  bool same = rows_saved_;
  for (const SolverRow& row : problem.rows()) same = same && row.G == row.assembled_G;
  if (same) return lu_.restore();
  // M.
  lu_.set_zero();
  for (const int i : problem.moving()) {
    const SolverBody& body = problem.at(i);
    Block& block = lu_.diagonal(body.unknown);
    block.topLeftCorner<3, 3>().diagonal().setConstant(body.kg);
    block.bottomRightCorner<3, 3>() = body.inertia;
  }
  // Where a row is at its bound, its impulse is constant and G = 0.
  // J' G J of rows.
  for (SolverRow& row : problem.rows()) {
    row.assembled_G = row.G;
    if (row.G != 0) add_row(problem, row);
  }
  lu_.save();
  rows_saved_ = true;
}

void NewtonMatrix::add_row(const ContactProblem& problem, const SolverRow& row) {
  BlockVector j[2], scaled[2];
  j[0] << row.a.linear, row.a.angular;
  j[1] << row.b.linear, row.b.angular;
  const int unknown[2] = {problem.unknown_of(row.a.body), problem.unknown_of(row.b.body)};
  for (int k = 0; k < 2; ++k) scaled[k] = row.G * j[k];
  for (int k = 0; k < 2; ++k) {
    if (unknown[k] >= 0) add_outer(scaled[k], j[k], lu_.diagonal(unknown[k]));
  }
  // Both sides on the same body.
  if (unknown[0] >= 0 && unknown[0] == unknown[1]) {
    add_outer(scaled[0], j[1], lu_.diagonal(unknown[0]));
    add_outer(scaled[1], j[0], lu_.diagonal(unknown[0]));
  }
  if (row.pair < 0) return;
  const auto blocks = lu_.pair_blocks(static_cast<std::size_t>(row.pair));
  add_outer(scaled[0], j[1], lu_.forward(blocks));
  add_outer(scaled[1], j[0], lu_.backward(blocks));
}

APRSIM_VECTOR_CLONES void NewtonMatrix::assemble_contacts(ContactProblem& problem) {
  for (std::size_t first = 0; first < problem.packs().size();) {
    const auto pair = problem.packs_of_pair(first);
    first += pair.size();
    const ContactPack& front = pair.front();
    const int a = problem.unknown_of(front.a), b = problem.unknown_of(front.b);
    // SAP's Hessian (Castro et al. 2022) with G from the projection; open contacts have G =
    // 0.
    // Sum over the pair's contacts, about the first of its bodies that moves.
    Matrix6 sum = Matrix6::zero();
    bool is_zero = true;
    for (const ContactPack& pack : pair) {
      if (!pack.has_derivative()) continue;
      is_zero = false;
      pack.add_jacobian_product(a >= 0, sum);
    }
    if (is_zero) continue;
    sum.add_to(lu_.diagonal(a >= 0 ? a : b));
    if (front.pair < 0) continue;
    // The other blocks: the same impulses, with moments about the centre of b.
    const Eigen::Vector3d shift = front.lever_b.at(0) - front.lever_a.at(0);
    const auto blocks = lu_.pair_blocks(static_cast<std::size_t>(front.pair));
    add_shifted(sum, shift, lu_.forward(blocks), lu_.backward(blocks), lu_.diagonal(b));
  }
}

bool NewtonMatrix::solve(std::span<BlockVector> x) { return lu_.factorise() && lu_.solve(x); }

}  // namespace aprsim::physics
