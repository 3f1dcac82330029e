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
// What is only held is held still. Where it presses on something else, friction is a little soft (1
// um/s for each N): perfectly hard friction at many points often has no solution near the last.
constexpr double kHoldingCfm = 1e-9, kPressingCfm = 1e-6;

using Values = Eigen::Map<Eigen::VectorXd>;

/// Two directions across n.
void across(const Vector3d& n, Vector3d& t1, Vector3d& t2) {
  dVector3 normal, p, q;
  ode::copy(n, normal);
  dPlaneSpace(normal, p, q);
  t1 = ode::vector(p);
  t2 = ode::vector(q);
}

/// Change of angular velocity of a free body in a step: one Newton step of the implicit equation.
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
  constexpr std::size_t kBodies = 32, kTies = 96, kLimited = MixedLcp::kCapacity;
  bodies_.reserve(kBodies);
  ties_.reserve(kTies);
  limited_.reserve(kLimited);
  contacts_.reserve(kLimited / 3);
  tie_factor_.reserve(kTies * kTies);
  link_.reserve(kTies * kLimited);
  linked_.reserve(kLimited);
  y_tie_.reserve(kTies);
  p_tie_.reserve(kTies);
}

void ConstraintSystem::begin(Normals normals) {
  normals_ = normals;
  bodies_.clear();
  ties_.clear();
  limited_.clear();
  contacts_.clear();
  boxed_.clear();
}

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

void ConstraintSystem::join(int& index, Vector6& j, Vector6& m, double& missing,
                            const RowSide& side) const {
  if (side.body == nullptr) return;
  index = index_of(side.body);
  if (index < 0) {
    missing -= side.linear.dot(ode::vector(dBodyGetLinearVel(side.body))) +
               side.angular.dot(ode::vector(dBodyGetAngularVel(side.body)));
    return;
  }
  const Body& body = bodies_[static_cast<std::size_t>(index)];
  j << side.linear, side.angular;
  m << body.inverse_kg * side.linear, body.inverse_inertia_W * side.angular;
  missing -= side.linear.dot(body.v) + side.angular.dot(body.omega);
}

ConstraintSystem::Row ConstraintSystem::make_row(const RowSide& a, const RowSide& b, double target,
                                                 double cfm) const {
  Row row;
  row.softness = cfm / step_s_;
  row.missing = target;
  join(row.a, row.j_a, row.m_a, row.missing, a);
  join(row.b, row.j_b, row.m_b, row.missing, b);
  return row;
}

int ConstraintSystem::add_tie(const RowSide& a, const RowSide& b, double target_m_s, double cfm) {
  ties_.push_back(make_row(a, b, target_m_s, cfm));
  return static_cast<int>(ties_.size()) - 1;
}

void ConstraintSystem::add_limited(const RowSide& a, const RowSide& b, double target_m_s,
                                   double cfm, double lo_n, double hi_n) {
  limited_.push_back(make_row(a, b, target_m_s, cfm));
  boxed_.add({.lo = lo_n * step_s_, .hi = hi_n * step_s_});
}

void ConstraintSystem::add_touch(ContactConstraint& touch, dBodyID a, dBodyID b, double target_m_s,
                                 double cfm, const Vector3d& slide_W, double slide_m_s,
                                 const Vector3d& guess_W) {
  const Vector3d& p = touch.contact.p_W;
  const Vector3d& n = touch.contact.n_W;
  const auto side = [&p](dBodyID body, const Vector3d& direction) {
    if (body == nullptr) return RowSide{};
    const Vector3d lever = p - ode::vector(dBodyGetPosition(body));
    return RowSide{body, direction, lever.cross(direction)};
  };
  const auto add = [&](const Vector3d& direction, double target, double softness,
                       const MixedLcp::Row& bounds) {
    limited_.push_back(make_row(side(a, direction), side(b, -direction), target, softness));
    return boxed_.add(bounds, step_s_ * guess_W.dot(direction));
  };
  Contact contact{.touch = &touch};
  contact.first = add(n, target_m_s, cfm, {.lo = 0, .hi = std::numeric_limits<double>::infinity()});
  across(n, contact.t1, contact.t2);
  if (!slide_W.isZero()) {
    contact.t1 = slide_W;
    contact.t2 = n.cross(slide_W);
  }
  const double hard = normals_ == Normals::kTogether ? kPressingCfm : kHoldingCfm;
  add(contact.t1, slide_m_s, hard, {.normal = contact.first, .mu = touch.friction});
  add(contact.t2, 0, hard, {.normal = contact.first, .mu = touch.friction});
  contacts_.push_back(contact);
}

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

/// Factorises the ties' matrix and solves it for what is missing of them.
void ConstraintSystem::eliminate_ties() {
  const std::size_t n = ties_.size();
  tie_factor_.resize(n * n);
  y_tie_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i; k < n; ++k) tie_factor_[i * n + k] = coupling(ties_[i], ties_[k]);
    tie_factor_[i * n + i] += ties_[i].softness;
    y_tie_[i] = ties_[i].missing;
  }
  const int count = static_cast<int>(n);
  factorise(tie_factor_.data(), count, count);
  solve_lower(tie_factor_.data(), count, count, y_tie_.data());
}

/// The matrix of the limited rows, given that the ties hold.
void ConstraintSystem::couple_limited() {
  const std::size_t n = ties_.size(), m = limited_.size();
  const int count = static_cast<int>(n);
  link_.resize(n * m);
  linked_.resize(m);
  for (std::size_t i = 0; i < m; ++i) {
    double* link = link_.data() + i * n;
    bool any = false;
    for (std::size_t k = 0; k < n; ++k) {
      link[k] = coupling(limited_[i], ties_[k]);
      any = any || link[k] != 0;
    }
    linked_[i] = any;
    if (any) solve_lower(tie_factor_.data(), count, count, link);
    boxed_.b(static_cast<int>(i)) = limited_[i].missing;
    if (any) {
      boxed_.b(static_cast<int>(i)) -= Values(link, count).dot(Values(y_tie_.data(), count));
    }
  }
  for (std::size_t i = 0; i < m; ++i) {
    double* column = boxed_.column(static_cast<int>(i));
    for (std::size_t k = i; k < m; ++k) {
      double value = coupling(limited_[i], limited_[k]);
      if (linked_[i] && linked_[k]) {
        value -= Values(link_.data() + i * n, count).dot(Values(link_.data() + k * n, count));
      }
      column[k] = value;
      boxed_.column(static_cast<int>(k))[i] = value;
    }
    column[i] += limited_[i].softness;
  }
}

void ConstraintSystem::advance() {
  eliminate_ties();
  couple_limited();
  if (normals_ == Normals::kTogether) {
    boxed_.solve_together(kRelaxations, kMostChanges);
  } else {
    boxed_.solve_one_after_the_other();
  }
  const std::size_t n = ties_.size();
  const int count = static_cast<int>(n);
  for (std::size_t i = 0; i < limited_.size(); ++i) {
    const double impulse = boxed_.x(static_cast<int>(i));
    if (impulse == 0) continue;
    apply(limited_[i], impulse);
    if (linked_[i]) Values(y_tie_.data(), count) -= impulse * Values(link_.data() + i * n, count);
  }
  solve_lower_transposed(tie_factor_.data(), count, count, y_tie_.data());
  p_tie_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    apply(ties_[i], y_tie_[i]);
    p_tie_[i] = y_tie_[i] / step_s_;
  }
  for (Body& body : bodies_) move(body);
  write_forces();
}

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

void ConstraintSystem::move(Body& body) const {
  const Vector3d p = ode::vector(dBodyGetPosition(body.ode)) + step_s_ * body.v;
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
    ContactConstraint& touch = *contact.touch;
    touch.normal_n = boxed_.x(contact.first) / step_s_;
    touch.f_W = touch.normal_n * touch.contact.n_W +
                boxed_.x(contact.first + 1) / step_s_ * contact.t1 +
                boxed_.x(contact.first + 2) / step_s_ * contact.t2;
  }
}

}  // namespace aprsim::physics
