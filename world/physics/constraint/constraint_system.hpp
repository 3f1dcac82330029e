#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/constraint/contact_problem.hpp"
#include "world/physics/constraint/contact_solver.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"
#include "world/physics/engine/contact_material.hpp"
#include "world/physics/engine/engine.hpp"

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

/// Our own engine: forces and gravity change the velocities first, ContactSolver finds the
/// impulses, then each body moves freely over the step (docs/contact_solver.md). Joints are rows
/// (joint_rows.hpp). No call allocates after warm-up.
class ConstraintSystem final : public Engine {
 public:
  void begin(const EngineStep& step) override;
  void add_body(RigidBody& body) override;
  void add_joint(const FixedJoint& joint) override;
  void add_joint(const SliderJoint& joint) override;
  void add_joint(const HingeJoint& joint) override;
  void add_joint(const RodJoint& joint) override;
  /// The contact is warm-started with the constraint's guesses.
  void add_contact(RigidBody* a, RigidBody* b, ContactConstraint& constraint,
                   const ContactSetting& setting) override;
  EngineOutcome advance() override;
  [[nodiscard]] const ContactSolverStatistics* statistics() const override {
    return &solver_.statistics();
  }

  [[nodiscard]] double step_s() const { return step_s_; }
  /// A row whose force stays within bounds [N]; `force` becomes what was found.
  void add_row(const RowSide& a, const RowSide& b, double target_m_s, double compliance,
               double lo_n, double hi_n, JointForce& force);
  /// A bilateral row, whose force has no bound.
  void add_joint_row(const RowSide& a, const RowSide& b, double target_m_s, double compliance,
                     JointForce& force);

 private:
  /// A body in the system.
  struct Member {
    RigidBody* body = nullptr;
    bool moves = false;  ///< by the solution
    bool turns = false;  ///< enough to matter within the step
    bool spins = false;  ///< so fast that its motion must be known, not expected
    /// Behind the impulses, and its mean over the step: as expected, then as solved.
    Eigen::Vector3d omega_W, mean_omega_W;
    Eigen::Matrix3d arc_W;  ///< see arc_matrix(), of the mean; only where the body turns
  };
  /// Two bodies between which there are contacts, by their numbers in the system.
  struct Sides {
    int a = ContactProblem::kFixed, b = ContactProblem::kFixed;
    bool operator==(const Sides&) const = default;
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
  /// How much farther the first body's surface gets past the second one's in the step than the
  /// velocities behind the impulses take it: linear in the place.
  struct PairDrift {
    Sides sides;
    Eigen::Vector3d origin_W;              ///< where the vectors hold
    Eigen::Vector3d gain_W, omega_gain_W;  ///< by free rotation
    Eigen::Vector3d arc_W;                 ///< by the arcs of the points
    Eigen::Matrix3d arc_gradient;
    Eigen::Vector3d common_arc_W;  ///< of the rotation that both have in common, anywhere
  };
  /// The mean velocity of the first body's surface past the second one's over the step.
  struct PairVelocity {
    Sides sides;
    Eigen::Vector3d origin_W;
    Eigen::Vector3d v_W, omega_W;
    Eigen::Matrix3d arc_gradient;
    bool has_arcs = false;
    Eigen::Vector3d mean_omega_W;  ///< of the two bodies, as far as they turn
    [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector3d& p_W) const;
  };
  /// Done by contacts on the bodies in a step.
  struct Work {
    double sum_j = 0;
    double size_j = 0;  ///< of the parts that it is made of
  };
  [[nodiscard]] int index_of(RigidBody* body);
  void add_member(RigidBody& body, bool moves);
  [[nodiscard]] bool turns(const Eigen::Vector3d& omega_W) const;
  [[nodiscard]] bool turns(const Sides& sides) const;
  [[nodiscard]] ContactProblem::Side side(const RowSide& side);
  [[nodiscard]] double drift_of(const RowSide& side, int number) const;
  [[nodiscard]] Sides sides_of(RigidBody* a, RigidBody* b);
  [[nodiscard]] const PairDrift& pair_drift(const Contact& contact);
  [[nodiscard]] const PairVelocity& pair_velocity(const Contact& contact);
  [[nodiscard]] Eigen::Vector3d drift_of(const Contact& contact);
  [[nodiscard]] ContactSolver::Outcome solve();
  void take_solved_rotations();
  [[nodiscard]] bool correct_targets();
  [[nodiscard]] ContactSolver::Outcome solve_with_share(double share);
  [[nodiscard]] Work contact_work() const;
  void update_creep(const Contact& contact, const Eigen::Vector3d& impulse_ns);
  void move(const Member& member, const SolverBody& solved) const;

  double step_s_ = 0;
  ContactSolverParameters parameters_;
  ContactProblem problem_;
  ContactSolver solver_;
  Eigen::Vector3d gravity_W_ = Eigen::Vector3d::Zero();
  std::vector<Member> members_;  // by number, until the system is solved
  std::vector<JointForce*> forces_;
  std::vector<Contact> contacts_;
  bool may_make_energy_ = false;  // rebounds or deep contacts
  bool spins_ = false;            // any body
  // Contacts of a pair follow each other.
  struct {
    const RigidBody *a = nullptr, *b = nullptr;
    Sides sides;
  } last_bodies_;
  PairDrift last_drift_;
  PairVelocity last_velocity_;
};

}  // namespace aprsim::physics
