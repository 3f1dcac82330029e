#pragma once

#include <array>
#include <span>
#include <vector>

#include "world/physics/constraint/constraint_system.hpp"
#include "world/physics/constraint/contact_material.hpp"
#include "world/physics/islands.hpp"

namespace aprsim::physics {

/// Advances ODE by one step, phase by phase, and brings back the contact forces. Each phase is one
/// call of an ODE solver with only its bodies enabled and only its contacts made. No call
/// allocates after warm-up.
class StepSolver {
 public:
  explicit StepSolver(PhysicsModel& cell);

  /// Notes the state from which step() starts, so that undo() can return to it.
  void begin();
  void undo();
  /// Solves cell.touches and moves every solid; link and carriage poses are left wherever ODE put
  /// them.
  void step();
  [[nodiscard]] const Islands& islands() const { return islands_; }

  /// What a step needs of the one before. Of bodies at the border of a gripper's island, what they
  /// bear from beyond it: by body, force and torque about its ODE body's origin. Of grippers'
  /// islands, the touches that bore something: where the search for the next forces starts.
  struct Memory {
    std::vector<Eigen::Vector3d> force, torque;
    std::vector<ContactConstraint> grips;
  };
  [[nodiscard]] const Memory& save() const { return memory_; }
  void restore(const Memory& memory) { memory_ = memory; }

 private:
  enum class Method { kDirect, kIterative };
  void solve_grips();
  void solve_grip(int island, ConstraintSystem::Normals normals);
  void add_touches(int island);
  [[nodiscard]] Eigen::Vector3d last_force(const ContactConstraint& touch) const;
  void note_grip(int island);
  void copy_memory(const Memory& from, Memory& to) const;
  void solve_direct();
  void solve_iterative();
  void enable(Phase phase, bool on);
  void enable_only(std::initializer_list<Phase> phases);
  void apply_forces();
  void make_contacts(Phase phase);
  [[nodiscard]] bool place_link_of(const ContactConstraint& touch);
  [[nodiscard]] Eigen::Vector3d sliding_direction(const ContactConstraint& touch) const;
  void run(Method method);
  void read_forces();
  void drop_contacts();
  void cut_begin();
  void cut_end();

  using Bodies = std::vector<ode::SavedState>;
  using Grippers = std::vector<std::array<ode::SavedState, 4>>;
  /// Of the solids and grippers of the phases that are wanted.
  template <class Wanted>
  void save(const Wanted& wanted, Bodies& bodies, Grippers& grippers);
  template <class Wanted>
  void restore(const Wanted& wanted, const Bodies& bodies, const Grippers& grippers);
  [[nodiscard]] std::span<const int> solids() const { return cell_.simplification.solids(); }

  PhysicsModel& cell_;
  Islands islands_;
  ConstraintSystem system_;
  std::vector<int> tie_of_pair_;
  ode::JointGroup contacts_;
  std::vector<dJointFeedback> feedback_;
  std::vector<std::size_t> made_;  // touch of each contact joint
  Bodies saved_, before_;
  Grippers saved_grippers_, before_grippers_;
  std::vector<char> border_;  // bodies that are moved from outside in the iterative phase
  Memory memory_, memory_before_;
  std::vector<ContactConstraint> last_grips_;
};

}  // namespace aprsim::physics
