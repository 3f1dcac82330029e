#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/force_guess.hpp"
#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/constraint/contact_material.hpp"
#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"

namespace aprsim::physics {

/// One body's side of a velocity constraint, as its part of the Jacobian. The sum of both sides'
/// velocities is driven to the row's target. A null body is the ground; kinematic bodies keep their
/// velocity.
struct RowSide {
  RigidBody* body = nullptr;
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  /// The point that the row holds, from the body's centre of mass.
  Eigen::Vector3d lever_W = Eigen::Vector3d::Zero();

  /// The velocity along `d` of the point at `lever_W`.
  [[nodiscard]] static RowSide of_point(RigidBody& body, const Eigen::Vector3d& d,
                                        const Eigen::Vector3d& lever_W) {
    return {&body, d, lever_W.cross(d), lever_W};
  }
  /// The angular velocity about `axis`.
  [[nodiscard]] static RowSide of_turn(RigidBody& body, const Eigen::Vector3d& axis) {
    return {&body, Eigen::Vector3d::Zero(), axis};
  }
};

/// The force of a row, which warm-starts the next step. Rows never use a mean force.
struct RowForce {
  ForceGuess<double> guess_n{0};
  /// In the last step.
  [[nodiscard]] double last_n() const { return guess_n.last; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [guess_n] = self;
    io(guess_n);
  }
};

/// Some bodies with the joints and contacts between them, advanced together by one step: forces
/// and gravity change the velocities first, ContactSolver finds the impulses, then each body moves
/// freely over the step (docs/contact_solver.md). No call allocates after warm-up.
class ConstraintSystem {
 public:
  /// Empties the system. `residual_m_s`: see scene::Physics.
  void begin(double step_s, const Eigen::Vector3d& gravity_W, double residual_m_s);
  /// Adds a body that the step moves, and clears its load, which acts in this step.
  void add_body(RigidBody& body);
  /// A row whose force stays within bounds [N]; `force` becomes what was found.
  void add_row(const RowSide& a, const RowSide& b, double target_m_s, double compliance,
               double lo_n, double hi_n, RowForce& force);
  /// A bilateral row, whose force has no bound.
  void add_joint_row(const RowSide& a, const RowSide& b, double target_m_s, double compliance,
                     RowForce& force);
  /// Two bodies between which there are contacts, by their numbers in the system.
  struct Sides {
    int a = ContactProblem::kFixed, b = ContactProblem::kFixed;
  };
  /// Null bodies are the ground; bodies that have not been added are kinematic.
  [[nodiscard]] Sides sides(RigidBody* a, RigidBody* b);
  /// A contact, warm-started with the constraint's guesses.
  void add_contact(ContactConstraint& constraint, const Sides& sides,
                   const ContactResponse& response);

  /// Solves, moves the bodies, and writes the forces into the contacts' constraints and the
  /// RowForces.
  ContactSolver::Outcome advance();
  /// The course of the last advance().
  [[nodiscard]] const ContactSolverStatistics& statistics() const { return solver_.statistics(); }

 private:
  /// A body in the system.
  struct Member {
    RigidBody* body = nullptr;
    bool moves = false;  ///< by the solution
    bool turns = false;  ///< enough to matter within the step
    bool spins = false;  ///< so fast that its motion must be known, not expected
    /// Behind the impulses, and its mean over the step: as expected, then as solved.
    Eigen::Vector3d omega_W, mean_omega_W;
  };
  struct Contact {
    ContactConstraint* constraint = nullptr;
    Sides sides;
    Eigen::Vector3d target_v_W;    ///< without the rebound
    Eigen::Vector3d drift_v_W;     ///< that the target makes up for
    Eigen::Vector3d surface_v_W;   ///< of a moving surface
    double compliance_m_s_ns = 0;  ///< slip velocity per friction impulse
    double rebound_m_s = 0;
  };
  /// Done by contacts on the bodies in a step.
  struct Work {
    double sum_j = 0;
    double size_j = 0;  ///< of the parts that it is made of
  };
  [[nodiscard]] int index_of(RigidBody* body);
  void add_member(RigidBody& body, bool moves);
  [[nodiscard]] bool turns(const Eigen::Vector3d& omega_W) const;
  [[nodiscard]] ContactProblem::Side side(const RowSide& side);
  [[nodiscard]] double drift_of(const RowSide& side, int number) const;
  [[nodiscard]] Eigen::Vector3d drift_of(const Contact& contact) const;
  [[nodiscard]] ContactSolver::Outcome solve();
  void take_solved_rotations();
  [[nodiscard]] bool correct_targets();
  [[nodiscard]] ContactSolver::Outcome solve_with_share(double share);
  [[nodiscard]] Work contact_work() const;
  void update_creep(const Contact& contact, const Eigen::Vector3d& impulse_ns) const;
  void move(const Member& member, const SolverBody& solved) const;

  double step_s_ = 0;
  ContactSolverParameters parameters_;
  ContactProblem problem_;
  ContactSolver solver_;
  Eigen::Vector3d gravity_W_ = Eigen::Vector3d::Zero();
  std::vector<Member> members_;  // by number, until the system is solved
  std::vector<RowForce*> forces_;
  std::vector<Contact> contacts_;
  bool rebounds_ = false;  // of any contact
};

}  // namespace aprsim::physics
