#pragma once

#include <vector>

#include <Eigen/Core>

#include "world/physics/contacts/contact_search.hpp"
#include "world/physics/step/step_solver.hpp"

namespace aprsim::physics {

/// What is struck moves off in directions that nothing has been looked for. After a blow the step
/// is taken back, the contacts on the new ways are added, and it can be solved anew. No call
/// allocates after warm-up. The order is fixed by body numbers.
class BlowSearch {
 public:
  BlowSearch(PhysicsModel& model, ContactSearch& search, StepSolver& solver);

  /// Whether something is so fast that it may strike another: then the solver has to be able to
  /// take the step back.
  [[nodiscard]] bool strikes() const;
  /// Before a step, or a part of one, is solved.
  void begin() { looked_at_.clear(); }
  /// After it was solved: takes it back and adds contacts where a blow leads off the ways that have
  /// been looked at; false where there are none, and the step stands.
  [[nodiscard]] bool add_met();
  /// How many contacts had been there before those that add_met() has added last.
  [[nodiscard]] std::size_t known_contacts() const { return known_count_; }

 private:
  struct Motion {
    int body;
    Eigen::Vector3d v_com_W, omega_W;
  };
  [[nodiscard]] bool find_leaving();
  void move_as_leaving();
  [[nodiscard]] bool add_found();
  void set_velocity(const Motion& motion);
  [[nodiscard]] double apart_m(const Motion& a, const Motion& b) const;

  PhysicsModel& model_;
  ContactSearch& search_;
  StepSolver& solver_;
  std::vector<Motion> before_, leaving_, looked_at_;
  std::vector<char> off_the_way_;         ///< by body; what sleeps counts as well
  std::vector<ContactConstraint> known_;  ///< before the blow
  std::size_t known_count_ = 0;
};

}  // namespace aprsim::physics
