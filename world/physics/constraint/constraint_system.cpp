#include "world/physics/constraint/constraint_system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "world/physics/constraint/cholesky.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kRelaxations = 60, kMostChanges = 30;
// A part that is only held is held still. Coupled friction is a little soft (1 um/s for each N):
// perfectly hard friction at many points often has no solution near the last.
constexpr double kDecoupledCfm = 1e-9, kCoupledCfm = 1e-6;

using Values = Eigen::Map<Eigen::VectorXd>;

/// Two directions across n.
void across(const Vector3d& n, Vector3d& t1, Vector3d& t2) {
  dVector3 normal, p, q;
  ode::copy(n, normal);
  dPlaneSpace(normal, p, q);
  t1 = ode::vector(p);
  t2 = ode::vector(q);
}

/// Change of angular velocity of a free body in a step: one Newton iteration of the implicit Euler
/// step of I omega' + omega x I omega = 0, as in Catto, "Numerical Methods" (GDC 2015).
Vector3d gyroscopic(const Matrix3d& inertia_W, const Vector3d& omega, double step_s) {
  const Vector3d momentum = inertia_W * omega;
  const auto cross = [](const Vector3d& v) {
    Matrix3d m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
  };
  const Matrix3d slope = inertia_W + step_s * (cross(omega) * inertia_W - cross(momentum));
  return -step_s * (slope.inverse() * omega.cross(momentum));
}

}  // namespace

ConstraintSystem::ConstraintSystem(double step_s) : step_s_(step_s) {
  constexpr std::size_t kBodies = 32, kBilateral = 96, kBounded = MixedLcp::kCapacity;
  bodies_.reserve(kBodies);
  bilateral_.reserve(kBilateral);
  bounded_.reserve(kBounded);
  contacts_.reserve(kBounded / 3);
  bilateral_factor_.reserve(kBilateral * kBilateral);
  coupling_.reserve(kBilateral * kBounded);
  coupled_.reserve(kBounded);
  y_.reserve(kBilateral);
  bilateral_forces_.reserve(kBilateral);
}

void ConstraintSystem::begin(Normals normals) {
  normals_ = normals;
  bodies_.clear();
  bilateral_.clear();
  bounded_.clear();
  contacts_.clear();
  lcp_.clear();
}

/// Semi-implicit Euler as in ODE: forces, gravity and gyroscopic torque change the velocity first.
void ConstraintSystem::add_body(dBodyID ode, const Vector3d& force, const Vector3d& torque) {
  dMass mass;
  dBodyGetMass(ode, &mass);
  const Matrix3d R = ode::matrix(dBodyGetRotation(ode));
  const Matrix3d inertia = ode::matrix(mass.I);
  Body body;
  body.ode = ode;
  body.inverse_kg = 1 / mass.mass;
  body.inverse_inertia_W = R * inertia.inverse() * R.transpose();
  body.omega = ode::vector(dBodyGetAngularVel(ode));
  if (dBodyGetGyroscopicMode(ode) != 0) {
    body.omega += gyroscopic(R * inertia * R.transpose(), body.omega, step_s_);
  }
  // Velocities after the step as forces alone would make them.
  const Vector3d f = force + ode::vector(dBodyGetForce(ode));
  const Vector3d m = torque + ode::vector(dBodyGetTorque(ode));
  body.v = ode::vector(dBodyGetLinearVel(ode)) + step_s_ * body.inverse_kg * f;
  body.omega += step_s_ * (body.inverse_inertia_W * m);
  if (dBodyGetGravityMode(ode) != 0) {
    dVector3 gravity;
    dWorldGetGravity(dBodyGetWorld(ode), gravity);
    body.v += step_s_ * ode::vector(gravity);
  }
  dBodySetForce(ode, 0, 0, 0);
  dBodySetTorque(ode, 0, 0, 0);
  bodies_.push_back(body);
}

int ConstraintSystem::index_of(dBodyID body) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (bodies_[i].ode == body) return static_cast<int>(i);
  }
  return -1;
}

/// One side's Jacobian, its product with the inverse mass, and what its velocity lacks of the
/// target.
void ConstraintSystem::join(int& index, Vector6& j, Vector6& m, double& deficit,
                            const RowSide& side) const {
  if (side.body == nullptr) return;
  index = index_of(side.body);
  if (index < 0) {  // kinematic: it moves as it does
    deficit -= side.linear.dot(ode::vector(dBodyGetLinearVel(side.body))) +
               side.angular.dot(ode::vector(dBodyGetAngularVel(side.body)));
    return;
  }
  const Body& body = bodies_[static_cast<std::size_t>(index)];
  j << side.linear, side.angular;
  m << body.inverse_kg * side.linear, body.inverse_inertia_W * side.angular;
  deficit -= side.linear.dot(body.v) + side.angular.dot(body.omega);
}

ConstraintSystem::Row ConstraintSystem::make_row(const RowSide& a, const RowSide& b, double target,
                                                 double cfm) const {
  Row row;
  row.softness = cfm / step_s_;
  row.deficit = target;
  join(row.a, row.j_a, row.m_a, row.deficit, a);
  join(row.b, row.j_b, row.m_b, row.deficit, b);
  return row;
}

int ConstraintSystem::add_bilateral(const RowSide& a, const RowSide& b, double target_m_s,
                                    double cfm) {
  bilateral_.push_back(make_row(a, b, target_m_s, cfm));
  return static_cast<int>(bilateral_.size()) - 1;
}

void ConstraintSystem::add_bounded(const RowSide& a, const RowSide& b, double target_m_s,
                                   double cfm, double lo_n, double hi_n) {
  bounded_.push_back(make_row(a, b, target_m_s, cfm));
  lcp_.add({.lo = lo_n * step_s_, .hi = hi_n * step_s_});
}

void ConstraintSystem::add_contact(ContactConstraint& constraint, dBodyID a, dBodyID b,
                                   const ContactResponse& response, double target_m_s,
                                   const Vector3d& guess_W) {
  const Vector3d& p = constraint.contact.p_W;
  const Vector3d& n = constraint.contact.n_W;
  const auto side = [&p](dBodyID body, const Vector3d& direction) {
    if (body == nullptr) return RowSide{};
    const Vector3d lever = p - ode::vector(dBodyGetPosition(body));
    return RowSide{body, direction, lever.cross(direction)};
  };
  const auto add = [&](const Vector3d& direction, double target, double softness,
                       const MixedLcp::Row& bounds) {
    bounded_.push_back(make_row(side(a, direction), side(b, -direction), target, softness));
    return lcp_.add(bounds, step_s_ * guess_W.dot(direction));
  };
  // Normal, then both axes of friction: ODE's own choice unless one is given.
  Contact contact{.constraint = &constraint};
  contact.first =
      add(n, target_m_s, response.cfm, {.lo = 0, .hi = std::numeric_limits<double>::infinity()});
  across(n, contact.t1, contact.t2);
  if (response.directed) {
    contact.t1 = response.axis_W;
    contact.t2 = n.cross(response.axis_W);
  }
  const double hard = normals_ == Normals::kCoupled ? kCoupledCfm : kDecoupledCfm;
  const MixedLcp::Row friction{.normal = contact.first, .mu = constraint.friction};
  add(contact.t1, response.belt_m_s, hard, friction);
  add(contact.t2, 0, hard, friction);
  contacts_.push_back(contact);
}

/// An element of J M^-1 J^T.
double ConstraintSystem::coupling(const Row& r, const Row& s) {
  double sum = 0;
  if (r.a >= 0) {
    if (r.a == s.a) sum += r.j_a.dot(s.m_a);
    if (r.a == s.b) sum += r.j_a.dot(s.m_b);
  }
  if (r.b >= 0) {
    if (r.b == s.a) sum += r.j_b.dot(s.m_a);
    if (r.b == s.b) sum += r.j_b.dot(s.m_b);
  }
  return sum;
}

/// A_bb = L L^T for the bilateral rows, and y = L^-1 b for their velocity deficits.
void ConstraintSystem::eliminate_bilateral() {
  const std::size_t n = bilateral_.size();
  bilateral_factor_.resize(n * n);
  y_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i; k < n; ++k)
      bilateral_factor_[i * n + k] = coupling(bilateral_[i], bilateral_[k]);
    bilateral_factor_[i * n + i] += bilateral_[i].softness;
    y_[i] = bilateral_[i].deficit;
  }
  const int count = static_cast<int>(n);
  factorise(bilateral_factor_.data(), count, count);
  solve_lower(bilateral_factor_.data(), count, count, y_.data());
}

/// The bounded rows' problem with the bilateral rows eliminated: Schur complement
/// A_uu - A_ub A_bb^-1 A_bu, and right side b_u - A_ub A_bb^-1 b_b, both by way of L^-1 A_bu.
void ConstraintSystem::couple_bounded() {
  const std::size_t n = bilateral_.size(), m = bounded_.size();
  const int count = static_cast<int>(n);
  coupling_.resize(n * m);
  coupled_.resize(m);
  for (std::size_t i = 0; i < m; ++i) {
    double* c = coupling_.data() + i * n;
    bool any = false;
    for (std::size_t k = 0; k < n; ++k) {
      c[k] = coupling(bounded_[i], bilateral_[k]);
      any = any || c[k] != 0;
    }
    coupled_[i] = any;
    if (any) solve_lower(bilateral_factor_.data(), count, count, c);
    lcp_.b(static_cast<int>(i)) = bounded_[i].deficit;
    if (any) {
      lcp_.b(static_cast<int>(i)) -= Values(c, count).dot(Values(y_.data(), count));
    }
  }
  for (std::size_t i = 0; i < m; ++i) {
    // Symmetric: both halves at once.
    double* column = lcp_.column(static_cast<int>(i));
    for (std::size_t k = i; k < m; ++k) {
      double value = coupling(bounded_[i], bounded_[k]);
      if (coupled_[i] && coupled_[k]) {
        value -=
            Values(coupling_.data() + i * n, count).dot(Values(coupling_.data() + k * n, count));
      }
      column[k] = value;
      lcp_.column(static_cast<int>(k))[i] = value;
    }
    column[i] += bounded_[i].softness;
  }
}

/// Bilateral rows are eliminated, the bounded ones solved, the bilateral ones follow.
void ConstraintSystem::advance(api::SolverFailures& failures) {
  eliminate_bilateral();
  couple_bounded();
  if (normals_ == Normals::kCoupled) {
    if (!lcp_.solve_estimated(kRelaxations)) ++failures.not_converged;
    if (!homotopy_.continue_friction(lcp_, kMostChanges)) ++failures.estimated;
  } else {
    if (!lcp_.solve_decoupled()) ++failures.not_converged;
  }
  // Back substitution: what the bounded rows leave for the bilateral ones.
  const std::size_t n = bilateral_.size();
  const int count = static_cast<int>(n);
  for (std::size_t i = 0; i < bounded_.size(); ++i) {
    const double impulse = lcp_.x(static_cast<int>(i));
    if (impulse == 0) continue;
    apply(bounded_[i], impulse);
    if (coupled_[i]) Values(y_.data(), count) -= impulse * Values(coupling_.data() + i * n, count);
  }
  solve_lower_transposed(bilateral_factor_.data(), count, count, y_.data());
  bilateral_forces_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    apply(bilateral_[i], y_[i]);
    bilateral_forces_[i] = y_[i] / step_s_;
  }
  for (Body& body : bodies_) move(body);
  write_forces();
}

/// v += M^-1 J^T impulse.
void ConstraintSystem::apply(const Row& row, double impulse) {
  const auto push = [&](int index, const Vector6& m) {
    if (index < 0) return;
    Body& body = bodies_[static_cast<std::size_t>(index)];
    body.v += impulse * m.head<3>();
    body.omega += impulse * m.tail<3>();
  };
  push(row.a, row.m_a);
  push(row.b, row.m_b);
}

/// Positions from the new velocities.
void ConstraintSystem::move(Body& body) const {
  const Vector3d p = ode::vector(dBodyGetPosition(body.ode)) + step_s_ * body.v;
  // Rotation by the exponential map of omega over the step, as ODE does for finite rotations.
  const dReal* q = dBodyGetQuaternion(body.ode);
  const double half = 0.5 * step_s_, angle = half * body.omega.norm();
  const double sinc = angle < 1e-4 ? 1 - angle * angle / 6 : std::sin(angle) / angle;
  const Vector3d turn = half * sinc * body.omega;
  const Eigen::Quaterniond turned =
      Eigen::Quaterniond(std::cos(angle), turn.x(), turn.y(), turn.z()) *
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  const dQuaternion next = {turned.w(), turned.x(), turned.y(), turned.z()};
  ode::set_velocity(body.ode, body.v, body.omega);
  ode::set_position(body.ode, p);
  dBodySetQuaternion(body.ode, next);
}

void ConstraintSystem::write_forces() {
  for (const Contact& contact : contacts_) {
    ContactConstraint& constraint = *contact.constraint;
    constraint.normal_n = lcp_.x(contact.first) / step_s_;
    constraint.f_W = constraint.normal_n * constraint.contact.n_W +
                     lcp_.x(contact.first + 1) / step_s_ * contact.t1 +
                     lcp_.x(contact.first + 2) / step_s_ * contact.t2;
  }
}

}  // namespace aprsim::physics
