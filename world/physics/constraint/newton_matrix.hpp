#pragma once

#include <span>
#include <utility>
#include <vector>

#include "world/physics/constraint/block_lu.hpp"
#include "world/physics/constraint/contact_problem.hpp"

namespace aprsim::physics {

/// Newton's matrix M + J' G J of a problem, where G = -d gamma / d v_c, in sparse blocks of 6 by 6.
/// It is not symmetric where the De Saxce correction follows the velocities. No call allocates
/// after warm-up.
class NewtonMatrix {
 public:
  /// Sets the structure: which bodies each row and contact couples.
  void analyse(ContactProblem& problem);
  /// Fills in the numbers. Bodies and rows are only assembled again if a row's G has changed.
  void assemble(ContactProblem& problem);
  /// Factorises and solves, in place; once after assemble(). False if it is singular.
  [[nodiscard]] bool solve(std::span<BlockLu::BlockVector> x);

 private:
  void assemble_rows(ContactProblem& problem);
  void add_row(const ContactProblem& problem, const SolverRow& row);
  void assemble_contacts(ContactProblem& problem);

  BlockLu lu_;
  bool rows_saved_ = false;  // in lu_
  std::vector<std::pair<int, int>> pairs_;
};

}  // namespace aprsim::physics
