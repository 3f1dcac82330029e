#pragma once

#include <cstddef>
#include <vector>

#include "world/physics/constraint/contact_problem.hpp"

namespace aprsim::physics {

/// A copy of a problem's impulses: the best iterate so far. No call allocates after warm-up.
class SavedImpulses {
 public:
  void save(const ContactProblem& problem) {
    rows_.resize(problem.rows().size());
    contacts_.resize(problem.packs().size());
    for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i] = problem.rows()[i].gamma;
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const ContactPack& pack = problem.packs()[i];
      contacts_[i] = {pack.gamma, pack.torsion.impulse};
    }
  }
  /// Sets them in the same problem; velocities stay.
  void restore(ContactProblem& problem) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) problem.rows()[i].gamma = rows_[i];
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      problem.packs()[i].gamma = contacts_[i].gamma;
      problem.packs()[i].torsion.impulse = contacts_[i].torsion;
    }
  }

 private:
  struct PackImpulses {
    Vector3x4 gamma, torsion;
  };
  std::vector<double> rows_;
  std::vector<PackImpulses> contacts_;  // by pack
};

}  // namespace aprsim::physics
