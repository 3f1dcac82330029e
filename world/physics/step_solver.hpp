#pragma once

#include <array>
#include <span>
#include <vector>

#include "world/physics/constraint/constraint_system.hpp"
#include "world/physics/islands.hpp"

namespace aprsim::physics {

/// Advances the bodies by one step, phase by phase (see Phase), and brings back the contact forces.
/// Grips are solved by ConstraintSystem; each other phase is one call of an ODE solver with only
/// its bodies enabled and only its contacts made. No call allocates after warm-up.
class StepSolver {
 public:
  explicit StepSolver(PhysicsModel& model);

  /// Notes the state from which step() starts, so that undo() can return to it.
  void begin();
  void undo();
  /// Solves model.constraints and moves every awake root; link and carriage poses are left wherever
  /// ODE put them.
  void step();
  [[nodiscard]] const Islands& islands() const { return islands_; }

  /// What a step needs of the one before: the warm start. Of bodies at the border of a gripper's
  /// island, the reaction from beyond it: by body, force and torque about its ODE body's origin. Of
  /// grippers' islands, the contacts that bore a force: the next solution is searched from there.
  struct Memory {
    std::vector<Eigen::Vector3d> force, torque;
    std::vector<ContactConstraint> grips;
    api::SolverFailures failures;  ///< so far
  };
  [[nodiscard]] const Memory& save() const { return memory_; }
  void restore(const Memory& memory) { memory_ = memory; }
  [[nodiscard]] const api::SolverFailures& failures() const { return memory_.failures; }

 private:
  enum class Method { kDirect, kIterative };
  void solve_grips();
  void solve_grip(int island, ConstraintSystem::Normals normals);
  void add_contacts(int island);
  [[nodiscard]] Eigen::Vector3d warm_start(const ContactConstraint& constraint) const;
  void keep_grip(int island);
  void copy_memory(const Memory& from, Memory& to) const;
  void solve_direct();
  void solve_iterative();
  void enable_only(std::initializer_list<Phase> phases);
  void apply_forces();
  void make_contacts(Phase phase);
  [[nodiscard]] ContactResponse response_of(const ContactConstraint& constraint,
                                            const Eigen::Vector3d& slide_W);
  [[nodiscard]] Eigen::Vector3d sliding_direction(const ContactConstraint& constraint) const;
  void run(Method method);
  void read_forces();
  void drop_contacts();
  void freeze_border();
  void unfreeze_border();
  void keep_reactions();

  using Bodies = std::vector<ode::SavedState>;
  using Grippers = std::vector<std::array<ode::SavedState, 4>>;
  /// Of the roots and grippers of the phases that are wanted.
  template <class Wanted>
  void save(const Wanted& wanted, Bodies& bodies, Grippers& grippers);
  template <class Wanted>
  void restore(const Wanted& wanted, const Bodies& bodies, const Grippers& grippers);
  [[nodiscard]] std::span<const int> awake_roots() const {
    return model_.simplification.awake_roots();
  }

  PhysicsModel& model_;
  Islands islands_;
  ConstraintSystem system_;
  std::vector<int> first_row_of_pair_;
  ode::JointGroup contacts_;
  std::vector<dJointFeedback> feedback_;
  std::vector<std::size_t> made_;  // constraint of each contact joint
  Bodies saved_, before_;
  Grippers saved_grippers_, before_grippers_;
  std::vector<char> border_;  // bodies that are kinematic in the iterative phase
  Memory memory_, memory_before_;
  std::vector<ContactConstraint> last_grips_;
};

}  // namespace aprsim::physics
