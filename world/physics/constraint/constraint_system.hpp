#pragma once

#include <array>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/ode_handles.hpp"
#include "world/physics/constraint/mixed_lcp.hpp"

namespace aprsim::physics {

/// One row of velocity constraint between two bodies: along its Jacobian their relative velocity is
/// to be `target`, softened by `cfm`. Null bodies are the ground; kinematic ones move as they do.
struct RowSide {
  dBodyID body = nullptr;
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
};

/// Some bodies of ODE with the joints and contacts between them, advanced together by one step with
/// ODE's own equations (velocity steps, ERP, CFM), but solved otherwise: joints are eliminated
/// first, what is left is a MixedLcp. ODE's direct solver bounds friction by frictionless normal
/// forces, its iterative one lets grasps slip. No call allocates after warm-up.
class ConstraintSystem {
 public:
  explicit ConstraintSystem(double step_s);

  enum class Normals { kFrictionless, kTogether };
  /// Forgets everything; the next step is to find normal forces in this way.
  void begin(Normals normals);
  /// Adds a body that the step moves, with the forces that ODE has collected for it, plus `force`
  /// and `torque`; ODE's collection is emptied.
  void add_body(dBodyID body, const Eigen::Vector3d& force = Eigen::Vector3d::Zero(),
                const Eigen::Vector3d& torque = Eigen::Vector3d::Zero());
  /// A row of a joint, which pulls and pushes without bound. Returns its number.
  int add_tie(const RowSide& a, const RowSide& b, double target_m_s, double cfm);
  /// A row whose force stays within bounds [N].
  void add_limited(const RowSide& a, const RowSide& b, double target_m_s, double cfm, double lo_n,
                   double hi_n);
  /// A touch between two bodies, normal and friction; `guess_W` is a guess of its force [N].
  void add_touch(ContactConstraint& touch, dBodyID a, dBodyID b, double target_m_s, double cfm,
                 const Eigen::Vector3d& slide_W, double slide_m_s, const Eigen::Vector3d& guess_W);

  /// Solves, moves the bodies, and writes the forces into the touches.
  void advance();
  [[nodiscard]] double tie_force(int tie) const { return p_tie_[static_cast<std::size_t>(tie)]; }

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
    double missing = 0;  // velocity that is to be made up for
  };
  struct Contact {
    ContactConstraint* touch = nullptr;
    int first = 0;
    Eigen::Vector3d t1, t2;
  };

  [[nodiscard]] Row make_row(const RowSide& a, const RowSide& b, double target, double cfm) const;
  [[nodiscard]] int index_of(dBodyID body) const;
  void join(int& index, Vector6& j, Vector6& m, double& missing, const RowSide& side) const;
  [[nodiscard]] static double coupling(const Row& r, const Row& s);
  void eliminate_ties();
  void couple_limited();
  void apply(const Row& row, double impulse);
  void move(Body& body) const;
  void write_forces();

  double step_s_;
  Normals normals_ = Normals::kTogether;
  std::vector<Body> bodies_;
  std::vector<Row> ties_, limited_;
  std::vector<Contact> contacts_;
  MixedLcp boxed_;
  // Cholesky factor of the ties' matrix; what couples limited rows to ties, times its inverse
  std::vector<double> tie_factor_, link_;
  std::vector<char> linked_;
  std::vector<double> y_tie_, p_tie_;
};

}  // namespace aprsim::physics
