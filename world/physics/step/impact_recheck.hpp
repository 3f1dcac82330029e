#pragma once

#include <vector>

#include <Eigen/Core>

#include "world/physics/contacts/contact_search.hpp"
#include "world/physics/step/step_solver.hpp"

namespace aprsim::physics {

/// Searches contacts again after an impact. An impact deflects bodies into directions in which no
/// contacts were searched. The step is then undone, the contacts along the new displacements are
/// added, and the step can be solved again. No call allocates after warm-up. The order is fixed by
/// body numbers.
class ImpactRecheck {
 public:
  ImpactRecheck(PhysicsModel& model, ContactSearch& search, StepSolver& solver);

  /// Whether a body is fast enough for an impact: the solver must then be able to undo the step.
  [[nodiscard]] bool may_impact() const;
  /// Before a step or substep is solved.
  void begin() { searched_.clear(); }
  /// After the solve: undoes the step and adds contacts along displacements that were not searched.
  /// False if there are none; the solution then stays.
  [[nodiscard]] bool add_new_contacts();
  /// Number of contacts before those that add_new_contacts() added last.
  [[nodiscard]] std::size_t known_contacts() const { return known_count_; }

 private:
  struct Motion {
    int body;
    Eigen::Vector3d v_com_W, omega_W;
  };
  [[nodiscard]] bool find_departures();
  void apply_departures();
  [[nodiscard]] bool add_found();
  void set_velocity(const Motion& motion);
  [[nodiscard]] double difference_m(const Motion& a, const Motion& b) const;

  PhysicsModel& model_;
  ContactSearch& search_;
  StepSolver& solver_;
  std::vector<Motion> before_, departures_, searched_;
  std::vector<char> unsearched_;          ///< by body; set for sleeping ones, too
  std::vector<ContactConstraint> known_;  ///< before the impact
  std::size_t known_count_ = 0;
};

}  // namespace aprsim::physics
