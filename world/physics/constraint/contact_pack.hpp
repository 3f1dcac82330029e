#pragma once

#include <array>

#include <Eigen/Core>

#include "world/base/simd/vec4d.hpp"
#include "world/base/simd/vector6.hpp"
#include "world/physics/constraint/block_lu.hpp"
#include "world/physics/constraint/contact_description.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/constraint/friction_cone.hpp"
#include "world/physics/constraint/solver_body.hpp"
#include "world/physics/constraint/torsional_friction.hpp"

namespace aprsim::physics {

/// Up to four contacts of the same two bodies, one per lane of a vector register (idea: Catto 2024,
/// "SIMD matters", box2d.org). Unused lanes have neither friction nor metric, and no impulse.
/// Vectors without a suffix are in the contact frames (n, t1, t2). Symbols: docs/contact_solver.md.
struct ContactPack {
  using Vector3 = Eigen::Vector3d;
  using BlockVector = BlockLu::BlockVector;

  int a = -1, b = -1;  ///< bodies
  int count = 0;
  int pair = -1;             ///< its two bodies' pair of blocks in Newton's matrix
  bool has_torsion = false;  ///< a contact bears spinning or rolling torques
  bool actuated = false;     ///< a row acts on one of the bodies

  // ---- as they were added
  Vector3x4 p_W, target_W;
  Vec4d friction, compliance, surface_compliance;  ///< the last one of friction
  Vector3x4 last_gamma_W, change_gamma_W, last_torsion_W, change_torsion_W;  ///< warm start

  // ---- derived once a step
  std::array<Vector3x4, 3> frame;  ///< rows n, t1, t2
  Vector3x4 lever_a, lever_b, target;
  FrictionCone delassus;      ///< in the metric of the diagonal of J M^-1 J'
  Vec4d friction_compliance;  ///< tangential counterpart of `compliance`

  // ---- the iterate
  FrictionCone regularization;  ///< in the metric R: compliance with the proximal term
  Vec4d de_saxce_correction;    ///< mu |v_t|, added to the normal velocity
  Vector3x4 gamma, proximal_gamma;
  Vector3x4 v_c, delta_v_c;  ///< J V - target; its change along a direction
  ImpulseDerivative G;

  TorsionalFriction torsion;  ///< used if has_torsion

  /// Empties it.
  void begin(int body_a, int body_b);
  [[nodiscard]] bool accepts(const ContactDescription& contact) const {
    return count < kLanes && contact.a == a && contact.b == b;
  }
  void add(const ContactDescription& contact);
  /// After the last add(): derives frames, levers and Delassus diagonals, and sets the extrapolated
  /// warm start. Null bodies are fixed.
  void complete(const SolverBody* body_a, const SolverBody* body_b,
                const ContactSolverParameters& parameters);

  [[nodiscard]] Vector3x4 to_frame(const Vector3x4& v_W) const {
    return {dot(frame[0], v_W), dot(frame[1], v_W), dot(frame[2], v_W)};
  }
  [[nodiscard]] Vector3x4 from_frame(const Vector3x4& v) const {
    return v.x * frame[0] + v.y * frame[1] + v.z * frame[2];
  }
  /// Whether no contact bears an impulse.
  [[nodiscard]] bool is_idle() const;
  /// Sets the nearest impulses within the cones.
  void set_impulse(const Vector3x4& gamma_W, const Vector3x4& torsion_W);
  void set_target(int lane, const Vector3& target_v);
  void set_last_impulse() { set_impulse(last_gamma_W, last_torsion_W); }

  /// v_c = J V - target, and omega_c.
  void evaluate_velocities(const SolverBody* body_a, const SolverBody* body_b);
  /// v_c only.
  void evaluate_contact_velocities(const SolverBody* body_a, const SolverBody* body_b);
  /// Changes of v_c and omega_c along a direction d of the bodies' velocities.
  void evaluate_rates(const BlockVector* d_a, const BlockVector* d_b);
  void move_along(double step);

  void set_proximal_weight(double weight, const ContactSolverParameters& parameters);
  void update_proximal_point();
  void return_to_proximal_point();
  void update_de_saxce_correction() {
    de_saxce_correction = friction * sqrt(v_c.y * v_c.y + v_c.z * v_c.z);
  }
  /// The impulses that belong to the velocities v and omega, and their derivatives.
  /// `newton_on_slip`: the De Saxce correction follows v; else it is held.
  void evaluate_impulses(const Vector3x4& v, const Vector3x4& omega, bool newton_on_slip);
  /// Natural map of the complementarity, in units of velocity; the largest of all lanes.
  [[nodiscard]] double residual(const ContactSolverParameters& parameters) const;

  /// Impulses on both bodies, with moments about their centres of mass.
  struct BodyImpulses {
    Vector6 on_a, against_b;
    void operator+=(const BodyImpulses& other) {
      on_a = on_a + other.on_a;
      against_b = against_b + other.against_b;
    }
  };
  [[nodiscard]] BodyImpulses body_impulses() const;
  /// The same of contact impulses without torsion.
  [[nodiscard]] BodyImpulses body_impulses(const Vector3x4& contact_gamma) const;

  /// Number of contacts that bear an impulse or approach.
  [[nodiscard]] int bearing_count() const;
  /// Applies a share of a step of projected Gauss-Seidel; returns the change of gamma.
  [[nodiscard]] Vector3x4 relax(double share);

  /// On a, of one contact.
  [[nodiscard]] Vector3 impulse_W(int lane) const {
    return frame_of(lane).transpose() * gamma.at(lane);
  }
  [[nodiscard]] Vector3 torsion_W(int lane) const {
    return has_torsion ? Vector3(frame_of(lane).transpose() * torsion.impulse.at(lane))
                       : Vector3::Zero();
  }
  [[nodiscard]] Eigen::Matrix3d frame_of(int lane) const;
  /// delta_v_c . gamma: the part of the impulses in the slope of the cost along a direction.
  [[nodiscard]] double impulse_slope() const {
    const double out = horizontal_add(dot(delta_v_c, gamma));
    return has_torsion ? out + horizontal_add(dot(torsion.delta_omega_c, torsion.impulse)) : out;
  }
  /// Whether an impulse changes with the velocities.
  [[nodiscard]] bool has_derivative() const { return any((G.at[0][0] != 0) | (G.at[1][1] != 0)); }
  /// Adds J' G J, with moments about the centre of a or of b.
  void add_jacobian_product(bool about_a, Matrix6& out) const;

 private:
  void fill_unused_lanes();
  void set_tangents();
  void set_delassus(const SolverBody* body_a, const SolverBody* body_b);
  void set_open();
  void evaluate_contact_impulses(const Vector3x4& contact_v, bool newton_on_slip,
                                 const Mask4& opens);
  [[nodiscard]] static BodyImpulses sum_of(const Vector3x4& p, const Vector3x4& moment_a,
                                           const Vector3x4& moment_b);
};

// ---- as they are added

inline void ContactPack::begin(int body_a, int body_b) {
  a = body_a;
  b = body_b;
  count = 0;
  pair = -1;
  has_torsion = actuated = false;
  target_W = last_gamma_W = change_gamma_W = last_torsion_W = change_torsion_W = Vector3x4::zero();
  friction = compliance = torsion.spinning_m = torsion.rolling_m = broadcast(0);
  surface_compliance = broadcast(0);
}

inline void ContactPack::add(const ContactDescription& contact) {
  const int lane = count++;
  p_W.set(lane, contact.p);
  frame[0].set(lane, contact.n);
  target_W.set(lane, contact.target_v);
  friction[lane] = contact.friction;
  compliance[lane] = contact.compliance_m_s_ns;
  surface_compliance[lane] = contact.friction_compliance_m_s_ns;
  last_gamma_W.set(lane, contact.impulse_ns.last);
  change_gamma_W.set(lane, contact.impulse_ns.change);
  if (contact.spinning_m <= 0 && contact.rolling_m <= 0) return;
  has_torsion = true;
  torsion.spinning_m[lane] = contact.spinning_m;
  torsion.rolling_m[lane] = contact.rolling_m;
  last_torsion_W.set(lane, contact.torsional_impulse_nms.last);
  change_torsion_W.set(lane, contact.torsional_impulse_nms.change);
}

inline void ContactPack::complete(const SolverBody* body_a, const SolverBody* body_b,
                                  const ContactSolverParameters& parameters) {
  fill_unused_lanes();
  set_tangents();
  target = to_frame(target_W);
  set_delassus(body_a, body_b);
  friction_compliance = surface_compliance + parameters.friction_regularization * delassus.t;
  set_impulse(last_gamma_W + change_gamma_W, last_torsion_W + change_torsion_W);
}

inline void ContactPack::set_target(int lane, const Vector3& target_v) {
  target_W.set(lane, target_v);
  target.set(lane, {frame[0].at(lane).dot(target_v), frame[1].at(lane).dot(target_v),
                    frame[2].at(lane).dot(target_v)});
}

/// Values of the first lane keep the arithmetic of unused lanes finite.
inline void ContactPack::fill_unused_lanes() {
  for (int lane = count; lane < kLanes; ++lane) {
    p_W.set(lane, p_W.at(0));
    frame[0].set(lane, frame[0].at(0));
    target_W.set(lane, target_W.at(0));
  }
}

/// The first tangent is also perpendicular to the world axis with the least share of n.
inline void ContactPack::set_tangents() {
  const Vec4d zero = broadcast(0);
  const Vector3x4& n = frame[0];
  const Vec4d nx = abs(n.x), ny = abs(n.y), nz = abs(n.z);
  const Mask4 by_x = (nx <= ny) & (nx <= nz), by_y = ~by_x & (ny <= nz);
  const Vector3x4 t = {by_x   ? zero
                       : by_y ? -n.z
                              : n.y,
                       by_x   ? n.z
                       : by_y ? zero
                              : -n.x,
                       by_x   ? -n.y
                       : by_y ? n.x
                              : zero};
  frame[1] = (1 / sqrt(dot(t, t))) * t;
  frame[2] = cross(n, frame[1]);
}

/// The diagonal of J M^-1 J', with the larger one of both tangents.
inline void ContactPack::set_delassus(const SolverBody* body_a, const SolverBody* body_b) {
  const Vec4d zero = broadcast(0);
  Vec4d is_used = zero;
  for (int lane = 0; lane < count; ++lane) is_used[lane] = 1;
  Vec4d of_force[3] = {zero, zero, zero}, of_torque[3] = {zero, zero, zero};
  const auto add_side = [&](const SolverBody* body, Vector3x4& lever) {
    lever = Vector3x4::zero();
    if (body == nullptr) return;
    lever = p_W - Vector3x4::broadcast(body->com);
    if (!body->moves()) return;
    const auto accelerate = [body](const Vector3x4& m) -> Vector3x4 {
      const Eigen::Matrix3d& I = body->inverse_inertia;
      return {I(0, 0) * m.x + I(0, 1) * m.y + I(0, 2) * m.z,
              I(1, 0) * m.x + I(1, 1) * m.y + I(1, 2) * m.z,
              I(2, 0) * m.x + I(2, 1) * m.y + I(2, 2) * m.z};
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3x4 moment = cross(lever, frame[k]);
      of_force[k] += body->inverse_kg + dot(moment, accelerate(moment));
      if (has_torsion) of_torque[k] += dot(frame[k], accelerate(frame[k]));
    }
  };
  add_side(body_a, lever_a);
  add_side(body_b, lever_b);
  delassus.set(friction, is_used * of_force[0], is_used * max(of_force[1], of_force[2]));
  torsion.set_delassus(is_used * of_torque[0], is_used * max(of_torque[1], of_torque[2]));
}

// ---- velocities

inline void ContactPack::evaluate_contact_velocities(const SolverBody* body_a,
                                                     const SolverBody* body_b) {
  Vector3x4 v = Vector3x4::zero();
  const auto at = [](const Twist& twist, const Vector3x4& lever) {
    return Vector3x4::broadcast(twist.v) + cross(Vector3x4::broadcast(twist.omega), lever);
  };
  if (body_a != nullptr) v = at(body_a->twist, lever_a);
  if (body_b != nullptr) v = v - at(body_b->twist, lever_b);
  v_c = to_frame(v) - target;
}

inline void ContactPack::evaluate_velocities(const SolverBody* body_a, const SolverBody* body_b) {
  evaluate_contact_velocities(body_a, body_b);
  if (!has_torsion) return;
  Vector3 omega = Vector3::Zero();
  if (body_a != nullptr) omega += body_a->twist.omega;
  if (body_b != nullptr) omega -= body_b->twist.omega;
  torsion.omega_c = to_frame(Vector3x4::broadcast(omega));
}

inline void ContactPack::evaluate_rates(const BlockVector* d_a, const BlockVector* d_b) {
  Vector3x4 v = Vector3x4::zero();
  Vector3 omega = Vector3::Zero();
  const auto at = [](const BlockVector& d, const Vector3x4& lever) {
    return Vector3x4::broadcast(d.head<3>()) + cross(Vector3x4::broadcast(d.tail<3>()), lever);
  };
  if (d_a != nullptr) {
    v = at(*d_a, lever_a);
    omega += d_a->tail<3>();
  }
  if (d_b != nullptr) {
    v = v - at(*d_b, lever_b);
    omega -= d_b->tail<3>();
  }
  delta_v_c = to_frame(v);
  if (has_torsion) torsion.delta_omega_c = to_frame(Vector3x4::broadcast(omega));
}

inline void ContactPack::move_along(double step) {
  v_c = v_c + broadcast(step) * delta_v_c;
  if (has_torsion) {
    torsion.omega_c = torsion.omega_c + broadcast(step) * torsion.delta_omega_c;
  }
}

// ---- the proximal point

/// R = compliance + weight times the Delassus diagonal.
inline void ContactPack::set_proximal_weight(double weight,
                                             const ContactSolverParameters& parameters) {
  regularization.set(friction, compliance + weight * delassus.n,
                     friction_compliance + weight * delassus.t);
  torsion.set_regularization(weight + parameters.friction_regularization);
}

inline void ContactPack::update_proximal_point() {
  proximal_gamma = gamma;
  torsion.proximal_impulse = torsion.impulse;
}

inline void ContactPack::return_to_proximal_point() {
  gamma = proximal_gamma;
  torsion.impulse = torsion.proximal_impulse;
}

// ---- impulses

inline bool ContactPack::is_idle() const {
  if (any(gamma.x != 0)) return false;
  return !has_torsion || torsion.is_idle();
}

inline void ContactPack::set_impulse(const Vector3x4& gamma_W, const Vector3x4& torsion_W) {
  gamma = delassus.project(to_frame(gamma_W));
  torsion.impulse = has_torsion ? to_frame(torsion_W) : Vector3x4::zero();
}

inline void ContactPack::set_open() {
  gamma = Vector3x4::zero();
  G = ImpulseDerivative::zero();
  torsion.set_open();
}

inline void ContactPack::evaluate_impulses(const Vector3x4& v, const Vector3x4& omega,
                                           bool newton_on_slip) {
  // Contacts that separate and bore no impulse stay open: the De Saxce correction must not close
  // them.
  const Mask4 opens = (v.x >= 0) & (proximal_gamma.x == 0);
  if (newton_on_slip && all(opens)) return set_open();
  evaluate_contact_impulses(v, newton_on_slip, opens);
  // Torques are bounded by the normal impulse of the proximal point.
  if (has_torsion) torsion.evaluate_impulses(omega, max(proximal_gamma.x, broadcast(0)));
}

inline void ContactPack::evaluate_contact_impulses(const Vector3x4& contact_v, bool newton_on_slip,
                                                   const Mask4& opens) {
  // De Saxce: Coulomb's law is associated in the normal velocity v_n + mu |v_t|.
  Vector3x4 v = contact_v;
  const Vec4d slip_speed = sqrt(v.y * v.y + v.z * v.z);
  if (newton_on_slip) de_saxce_correction = friction * slip_speed;
  v.x += de_saxce_correction;
  // R gamma = (R - compliance) proximal_gamma - v, then projected onto the cone.
  const FrictionCone& R = regularization;
  const Vec4d kept_n = 1 - compliance * R.inverse_n, kept_t = 1 - friction_compliance * R.inverse_t;
  const Vector3x4 z = {kept_n * proximal_gamma.x - R.inverse_n * v.x,
                       kept_t * proximal_gamma.y - R.inverse_t * v.y,
                       kept_t * proximal_gamma.z - R.inverse_t * v.z};
  gamma = R.project(z, &G);
  if (!newton_on_slip) return;
  // Chain rule of the correction: it makes G unsymmetric.
  const Vec4d scale = friction * inverse_or_zero(slip_speed);
  const Vec4d by_y = scale * v.y, by_z = scale * v.z;
  for (auto& row : G.at) {
    row[1] += by_y * row[0];
    row[2] += by_z * row[0];
  }
  const Vec4d zero = broadcast(0);
  gamma = {opens ? zero : gamma.x, opens ? zero : gamma.y, opens ? zero : gamma.z};
  for (auto& row : G.at) {
    for (Vec4d& value : row) value = opens ? zero : value;
  }
}

inline double ContactPack::residual(const ContactSolverParameters& parameters) const {
  // gamma - P(gamma - W^-1 v), with the De Saxce correction in v.
  const Vec4d slip_speed = sqrt(v_c.y * v_c.y + v_c.z * v_c.z);
  const Vector3x4 v = {v_c.x + compliance * gamma.x + friction * slip_speed,
                       v_c.y + friction_compliance * gamma.y,
                       v_c.z + friction_compliance * gamma.z};
  const FrictionCone& W = delassus;
  const Vector3x4 off = gamma - W.project({gamma.x - W.inverse_n * v.x, gamma.y - W.inverse_t * v.y,
                                           gamma.z - W.inverse_t * v.z});
  // Fast sliding is solved to a share of its speed.
  Vec4d out = max(W.n * abs(off.x), W.t * max(abs(off.y), abs(off.z))) -
              parameters.sliding_relative_tolerance * slip_speed;
  if (has_torsion) {
    out = max(out, torsion.spinning_residual(gamma.x, parameters.angular_lever_m));
    out = max(out, torsion.rolling_residual(gamma.x, parameters.angular_lever_m));
  }
  return horizontal_max(out);
}

/// Sums over the lanes.
inline ContactPack::BodyImpulses ContactPack::sum_of(const Vector3x4& p, const Vector3x4& moment_a,
                                                     const Vector3x4& moment_b) {
  const Vec4d head_a = horizontal_add(p.x, p.y, p.z, moment_a.x);
  const Vec4d tails = horizontal_add(moment_a.y, moment_a.z, moment_b.y, moment_b.z);
  Vec4d head_b = head_a;
  head_b[3] = horizontal_add(moment_b.x);
  return {Vector6::join(head_a, tails, false), Vector6::join(head_b, tails, true)};
}

inline ContactPack::BodyImpulses ContactPack::body_impulses(const Vector3x4& contact_gamma) const {
  const Vector3x4 p = from_frame(contact_gamma);
  return sum_of(p, cross(lever_a, p), cross(lever_b, p));
}

inline ContactPack::BodyImpulses ContactPack::body_impulses() const {
  if (!has_torsion) return body_impulses(gamma);
  const Vector3x4 p = from_frame(gamma), t = from_frame(torsion.impulse);
  return sum_of(p, cross(lever_a, p) + t, cross(lever_b, p) + t);
}

// ---- relaxation

inline int ContactPack::bearing_count() const {
  const Mask4 bears = ((gamma.x > 0) | (v_c.x < 0)) & (delassus.n > 0);
  return -static_cast<int>(bears[0] + bears[1] + bears[2] + bears[3]);
}

inline Vector3x4 ContactPack::relax(double share) {
  const Vec4d slip_speed = sqrt(v_c.y * v_c.y + v_c.z * v_c.z);
  const Vec4d v_n = v_c.x + compliance * gamma.x + friction * slip_speed;
  const FrictionCone& W = delassus;
  const Vector3x4 before = gamma;
  const Vec4d v_y = v_c.y + friction_compliance * gamma.y;
  const Vec4d v_z = v_c.z + friction_compliance * gamma.z;
  gamma = W.project({gamma.x - share * (W.inverse_n * v_n), gamma.y - share * (W.inverse_t * v_y),
                     gamma.z - share * (W.inverse_t * v_z)});
  return gamma - before;
}

// ---- Newton's matrix

inline Eigen::Matrix3d ContactPack::frame_of(int lane) const {
  Eigen::Matrix3d out;
  out << frame[0].at(lane).transpose(), frame[1].at(lane).transpose(),
      frame[2].at(lane).transpose();
  return out;
}

inline void ContactPack::add_jacobian_product(bool about_a, Matrix6& out) const {
  const Vector3x4& lever = about_a ? lever_a : lever_b;
  // Rows of G F and of G (lever x F), and of the torsional G times F, where F is the frame.
  std::array<Vector3x4, 3> forces, moments, torques;
  for (std::size_t k = 0; k < 3; ++k) {
    forces[k] = G.at[k][0] * frame[0] + G.at[k][1] * frame[1] + G.at[k][2] * frame[2];
    moments[k] = cross(lever, forces[k]);
  }
  if (has_torsion) torques = torsion.derivative_rows(frame);
  // Columns of F' G F and F' G (lever x F), then their moments about the centre.
  const auto column = [this](const Vec4d& by_0, const Vec4d& by_1, const Vec4d& by_2) {
    return by_0 * frame[0] + by_1 * frame[1] + by_2 * frame[2];
  };
  std::array<Vector3x4, 6> top, bottom;
  top[0] = column(forces[0].x, forces[1].x, forces[2].x);
  top[1] = column(forces[0].y, forces[1].y, forces[2].y);
  top[2] = column(forces[0].z, forces[1].z, forces[2].z);
  top[3] = column(moments[0].x, moments[1].x, moments[2].x);
  top[4] = column(moments[0].y, moments[1].y, moments[2].y);
  top[5] = column(moments[0].z, moments[1].z, moments[2].z);
  for (std::size_t j = 0; j < 6; ++j) bottom[j] = cross(lever, top[j]);
  if (has_torsion) {
    bottom[3] = bottom[3] + column(torques[0].x, torques[1].x, torques[2].x);
    bottom[4] = bottom[4] + column(torques[0].y, torques[1].y, torques[2].y);
    bottom[5] = bottom[5] + column(torques[0].z, torques[1].z, torques[2].z);
  }
  // Sums over the lanes, two columns' tails at a time.
  for (std::size_t j = 0; j < 6; j += 2) {
    const Vec4d tails = horizontal_add(bottom[j].y, bottom[j].z, bottom[j + 1].y, bottom[j + 1].z);
    for (const std::size_t k : {j, j + 1}) {
      const Vec4d head = horizontal_add(top[k].x, top[k].y, top[k].z, bottom[k].x);
      out.column[k] = out.column[k] + Vector6::join(head, tails, k > j);
    }
  }
}

}  // namespace aprsim::physics
