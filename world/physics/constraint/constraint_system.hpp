#pragma once

#include <array>
#include <vector>

#include <Eigen/Geometry>

#include "world/api/snapshot.hpp"
#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/ode_handles.hpp"
#include "world/physics/constraint/contact_material.hpp"
#include "world/physics/constraint/friction_homotopy.hpp"
#include "world/physics/constraint/mixed_lcp.hpp"

namespace aprsim::physics {

/// One body's side of a velocity constraint: along its Jacobian the relative velocity of both sides
/// is to be `target`, softened by `cfm`. Null bodies are the ground; kinematic ones move as they
/// do.
struct RowSide {
  dBodyID body = nullptr;
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
};

/// Some bodies of ODE with the joints and contacts between them, advanced together by one step with
/// ODE's own equations (velocity steps, ERP, CFM), but solved otherwise: bilateral rows, those of
/// joints, are eliminated by a Schur complement; the bounded rows that remain are a MixedLcp. ODE's
/// direct solver bounds friction by frictionless normal forces, its iterative one lets grasps slip.
/// No call allocates after warm-up.
class ConstraintSystem {
 public:
  explicit ConstraintSystem(double step_s);

  enum class Normals { kCoupled, kDecoupled };
  /// Forgets everything. kCoupled: normal forces with friction, the friction bounds following them.
  /// kDecoupled: normal forces as without friction.
  void begin(Normals normals);
  /// Adds a body that the step moves, with the forces that ODE has collected for it, plus `force`
  /// and `torque`; ODE's collection is emptied.
  void add_body(dBodyID body, const Eigen::Vector3d& force = Eigen::Vector3d::Zero(),
                const Eigen::Vector3d& torque = Eigen::Vector3d::Zero());
  /// A bilateral row, whose force has no bound. Returns its number.
  int add_bilateral(const RowSide& a, const RowSide& b, double target_m_s, double cfm);
  /// A row whose force stays within bounds [N].
  void add_bounded(const RowSide& a, const RowSide& b, double target_m_s, double cfm, double lo_n,
                   double hi_n);
  /// The rows of a contact, normal and friction; `target_m_s` of the normal row. The search starts
  /// at the force `guess_W` [N].
  void add_contact(ContactConstraint& constraint, dBodyID a, dBodyID b,
                   const ContactResponse& response, double target_m_s,
                   const Eigen::Vector3d& guess_W);

  /// Solves, moves the bodies, and writes the forces into the contacts' constraints. Counts what
  /// it could not solve exactly.
  void advance(api::SolverFailures& failures);
  [[nodiscard]] double bilateral_force_n(int row) const {
    return bilateral_forces_[static_cast<std::size_t>(row)];
  }

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  struct Body {
    dBodyID ode = nullptr;
    double inverse_kg = 0;
    Eigen::Matrix3d inverse_inertia_W;
    Eigen::Vector3d v, omega;  // as forces alone would make them, later as solved
  };
  struct Row {
    int a = -1, b = -1;          // moved bodies
    Vector6 j_a, j_b, m_a, m_b;  // Jacobian, and its product with the inverse mass
    double softness = 0;
    double deficit = 0;  // velocity still lacking along the row
  };
  struct Contact {
    ContactConstraint* constraint = nullptr;
    int first = 0;
    Eigen::Vector3d t1, t2;
  };

  [[nodiscard]] Row make_row(const RowSide& a, const RowSide& b, double target, double cfm) const;
  [[nodiscard]] int index_of(dBodyID body) const;
  void join(int& index, Vector6& j, Vector6& m, double& deficit, const RowSide& side) const;
  [[nodiscard]] static double coupling(const Row& r, const Row& s);
  void eliminate_bilateral();
  void couple_bounded();
  void apply(const Row& row, double impulse);
  void move(Body& body) const;
  void write_forces();

  double step_s_;
  Normals normals_ = Normals::kCoupled;
  std::vector<Body> bodies_;
  std::vector<Row> bilateral_, bounded_;
  std::vector<Contact> contacts_;
  MixedLcp lcp_;
  FrictionHomotopy homotopy_;
  // Cholesky factor L of the bilateral rows' matrix; per bounded row, L^-1 times its coupling to
  // the bilateral rows, and whether there is any
  std::vector<double> bilateral_factor_, coupling_;
  std::vector<char> coupled_;
  std::vector<double> y_, bilateral_forces_;
};

}  // namespace aprsim::physics
