#pragma once

#include <array>

#include <Eigen/Core>

#include "world/base/simd/lanes.hpp"
#include "world/base/simd/six.hpp"
#include "world/physics/constraint/block_lu.hpp"
#include "world/physics/constraint/solver_body.hpp"

namespace aprsim::physics {

/// Where the search begins: at the last step's impulse, or by the change to it farther, whichever
/// fits the step better as a whole.
template <typename Value>
struct ImpulseGuess {
  Value last, change;
};

/// A contact as ContactSolver is told of it. SI, world axes.
struct ContactDescription {
  int a = -1, b = -1;  ///< bodies, -1 = what does not move
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();  ///< from b into a
  double friction = 0;
  double spinning_m = 0;  ///< the torque about n that friction bears, per normal force
  double rolling_m = 0;   ///< the same across n
  /// Velocity of a relative to b that the contact aims at: along n the least (a gap may close, or
  /// penetration is to be corrected), across n that of a surface in motion.
  Eigen::Vector3d target_v = Eigen::Vector3d::Zero();
  double softness_m_s_ns = 0;  ///< normal velocity per normal impulse
  ImpulseGuess<Eigen::Vector3d> impulse_ns = {Eigen::Vector3d::Zero(),
                                              Eigen::Vector3d::Zero()};  ///< on a
  /// Torque of friction on a, times the step.
  ImpulseGuess<Eigen::Vector3d> turn_nms = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
};

/// Derivatives of impulses by velocities, both in contacts' frames, with the sign turned.
struct PackGain {
  Lanes at[3][3];
};

/// The friction cones |x_t| <= mu x_n in the metric diag(n, t, t). Without a metric (a body on
/// nothing) the cone has only its tip.
struct PackCone {
  Lanes mu, n, t;
  Lanes per_n, per_t;    // 1 / n, 1 / t
  Lanes leaning, share;  // mu t / n, 1 / (1 + mu^2 t / n)

  void set(const Lanes& friction, const Lanes& metric_n, const Lanes& metric_t);
  /// Projection onto the cone in its metric; `gain`, if wanted, is its derivative times the
  /// metric's inverse.
  [[nodiscard]] Lanes3 project(const Lanes3& z, PackGain* gain = nullptr) const;
};

/// Up to four contacts of the same two bodies, side by side (Catto 2024, "SIMD matters", box2d.org,
/// for the idea). What is missing to four has neither friction nor metric, and so never bears
/// anything. Vectors without a suffix are in the frames (n, t1, t2).
struct ContactPack {
  using Vector3 = Eigen::Vector3d;
  using Vector6 = BlockLu::Vector6;

  int a = -1, b = -1;  ///< bodies
  int count = 0;
  int place = -1;      ///< of the pair of its bodies in the matrix
  bool turns = false;  ///< one of them bears torques
  bool loose = false;  ///< of bodies that nothing drives

  // ---- as told
  Lanes3 p_W, target_W;
  Lanes friction, spinning, rolling, softness;
  Lanes3 last_W, change_W, last_turn_W, change_turn_W;  ///< impulses, torques times the step

  // ---- what follows from it
  std::array<Lanes3, 3> frame;  ///< rows, the first of which is told
  Lanes3 lever_a, lever_b, target;
  PackCone W;                ///< by the diagonal of J M^-1 J'
  Lanes W_spin, W_roll;      ///< the same of torques
  Lanes per_spin, per_roll;  ///< their inverses, or 0

  // ---- the search
  PackCone D;  ///< by softness with the proximal term
  Lanes per_D_spin, per_D_roll;
  Lanes slip;  ///< De Saxce's correction of the normal velocity
  Lanes3 x, centre, y, rate;
  PackGain gain;
  /// Torques of friction: about n, and across it.
  Lanes3 torque, torque_centre, turn, turn_rate;
  Lanes spin_gain;
  Lanes roll_gain_yy, roll_gain_yz, roll_gain_zz;

  /// With no contacts yet.
  void begin(int body_a, int body_b);
  [[nodiscard]] bool takes(const ContactDescription& contact) const {
    return count < kLanes && contact.a == a && contact.b == b;
  }
  void add(const ContactDescription& contact);
  /// After the last of them: what follows from it, and the first guess. Null is what does not move.
  void complete(const SolverBody* body_a, const SolverBody* body_b);

  [[nodiscard]] Lanes3 to_frame(const Lanes3& v_W) const {
    return {dot(frame[0], v_W), dot(frame[1], v_W), dot(frame[2], v_W)};
  }
  [[nodiscard]] Lanes3 from_frame(const Lanes3& v) const {
    return v.x * frame[0] + v.y * frame[1] + v.z * frame[2];
  }
  /// Bears nothing.
  [[nodiscard]] bool idle() const;
  /// To the nearest impulses within the cones.
  void set_impulse(const Lanes3& impulse_W, const Lanes3& turn_W);
  void leave();

  /// y = J V - target.
  void evaluate_velocities(const SolverBody* body_a, const SolverBody* body_b);
  /// The part of it that contacts without torques have.
  void evaluate_contact_velocities(const SolverBody* body_a, const SolverBody* body_b);
  /// Changes of y along the direction d of the bodies' velocities.
  void evaluate_rates(const Vector6* d_a, const Vector6* d_b);
  void move_along(double step);
  void set_softness(double epsilon, double hard_tangent);
  void recentre_slip() { slip = friction * root(y.y * y.y + y.z * y.z); }
  /// Those that belong to velocities as y and turn, and their derivatives. `exact`: the slip
  /// follows.
  void evaluate_impulses(const Lanes3& contact_v, const Lanes3& turn_v, bool exact,
                         double hard_tangent);
  /// How far each is from complementarity: the natural map, in units of velocity.
  [[nodiscard]] double residual(double hard_tangent, double sliding_share, double lever) const;

  /// What all of them do to the bodies: impulses, and moments about their centres.
  struct Net {
    Six on_a, against_b;
  };
  [[nodiscard]] Net net() const;
  [[nodiscard]] Net net_of(const Lanes3& impulse) const;
  [[nodiscard]] static Net net_of(const Lanes3& p, const Lanes3& moment_a, const Lanes3& moment_b);

  /// How many bear something, or would.
  [[nodiscard]] int bearing() const;
  /// A share of a step of projected relaxation; the impulses' changes.
  [[nodiscard]] Lanes3 relax(double share);

  /// What one of them does to a.
  [[nodiscard]] Vector3 impulse_W(int lane) const {
    return frame_of(lane).transpose() * x.at(lane);
  }
  [[nodiscard]] Vector3 torque_W(int lane) const {
    return turns ? Vector3(frame_of(lane).transpose() * torque.at(lane)) : Vector3::Zero();
  }
  [[nodiscard]] Eigen::Matrix3d frame_of(int lane) const;
  /// Along `rate`, summed up.
  [[nodiscard]] double power() const {
    const double out = sum(dot(rate, x));
    return turns ? out + sum(dot(turn_rate, torque)) : out;
  }
  /// Does an impulse change with the velocities?
  [[nodiscard]] bool yields() const { return any((gain.at[0][0] != 0) | (gain.at[1][1] != 0)); }
  /// Adds J gain J', by moments about a's centre or b's.
  void add_gain(bool about_a, SixColumns& out) const;
};

// ---- cones

inline void PackCone::set(const Lanes& friction, const Lanes& metric_n, const Lanes& metric_t) {
  mu = friction;
  n = metric_n;
  t = metric_t;
  per_n = inverse_or_zero(n);
  per_t = inverse_or_zero(t);
  leaning = mu * t * per_n;
  share = 1 / (1 + mu * leaning);
}

inline Lanes3 PackCone::project(const Lanes3& z, PackGain* gain) const {
  const Lanes zero = spread(0);
  const Lanes across = root(z.y * z.y + z.z * z.z);
  const LaneMask inside = (z.x >= 0) & (across <= mu * z.x);
  const LaneMask tip = z.x <= -leaning * across;
  const auto choose = [&](const Lanes& within, const Lanes& on) {
    return inside ? within : tip ? zero : on;
  };
  // Onto the cone's generator, as seen in the metric.
  const Lanes xn = share * (z.x + leaning * across), xt = mu * xn;
  const Lanes per_across = inverse_or_zero(across);
  const Lanes ty = across > 0 ? z.y * per_across : spread(1), tz = z.z * per_across;
  if (gain != nullptr) {
    // Along the generator, and around the cone.
    const Lanes nn = share * per_n, nt = mu * nn, tt = mu * nt, around = xt * per_across * per_t;
    auto& g = gain->at;
    g[0][0] = choose(per_n, nn);
    g[0][1] = g[1][0] = choose(zero, nt * ty);
    g[0][2] = g[2][0] = choose(zero, nt * tz);
    g[1][1] = choose(per_t, tt * ty * ty + around * tz * tz);
    g[2][2] = choose(per_t, tt * tz * tz + around * ty * ty);
    g[1][2] = g[2][1] = choose(zero, (tt - around) * ty * tz);
  }
  return {choose(z.x, xn), choose(z.y, xt * ty), choose(z.z, xt * tz)};
}

// ---- what is told

inline void ContactPack::begin(int body_a, int body_b) {
  a = body_a;
  b = body_b;
  count = 0;
  place = -1;
  turns = loose = false;
  target_W = last_W = change_W = last_turn_W = change_turn_W = Lanes3::zero();
  friction = spinning = rolling = softness = spread(0);
}

inline void ContactPack::add(const ContactDescription& contact) {
  const int lane = count++;
  p_W.set(lane, contact.p);
  frame[0].set(lane, contact.n);
  target_W.set(lane, contact.target_v);
  friction[lane] = contact.friction;
  spinning[lane] = contact.spinning_m;
  rolling[lane] = contact.rolling_m;
  softness[lane] = contact.softness_m_s_ns;
  last_W.set(lane, contact.impulse_ns.last);
  change_W.set(lane, contact.impulse_ns.change);
  last_turn_W.set(lane, contact.turn_nms.last);
  change_turn_W.set(lane, contact.turn_nms.change);
  turns = turns || contact.spinning_m > 0 || contact.rolling_m > 0;
}

inline void ContactPack::complete(const SolverBody* body_a, const SolverBody* body_b) {
  const Lanes zero = spread(0);
  Lanes present = zero;
  for (int lane = 0; lane < count; ++lane) present[lane] = 1;
  for (int lane = count; lane < kLanes; ++lane) {
    p_W.set(lane, p_W.at(0));
    frame[0].set(lane, frame[0].at(0));
    target_W.set(lane, target_W.at(0));
  }
  // Two directions across n: the first across the axis that is least along n, too.
  const Lanes3& n = frame[0];
  const Lanes nx = size_of(n.x), ny = size_of(n.y), nz = size_of(n.z);
  const LaneMask by_x = (nx <= ny) & (nx <= nz), by_y = ~by_x & (ny <= nz);
  const Lanes3 t = {by_x   ? zero
                    : by_y ? -n.z
                           : n.y,
                    by_x   ? n.z
                    : by_y ? zero
                           : -n.x,
                    by_x   ? -n.y
                    : by_y ? n.x
                           : zero};
  frame[1] = (1 / root(dot(t, t))) * t;
  frame[2] = cross(n, frame[1]);
  target = to_frame(target_W);
  // The diagonal of J M^-1 J'.
  Lanes of_force[3] = {zero, zero, zero}, of_torque[3] = {zero, zero, zero};
  const auto add_side = [&](const SolverBody* body, Lanes3& lever) {
    lever = Lanes3::zero();
    if (body == nullptr) return;
    lever = p_W - Lanes3::of(body->com);
    if (!body->moves()) return;
    const auto turned = [body](const Lanes3& m) -> Lanes3 {
      const Eigen::Matrix3d& I = body->inverse_inertia;
      return {I(0, 0) * m.x + I(0, 1) * m.y + I(0, 2) * m.z,
              I(1, 0) * m.x + I(1, 1) * m.y + I(1, 2) * m.z,
              I(2, 0) * m.x + I(2, 1) * m.y + I(2, 2) * m.z};
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const Lanes3 moment = cross(lever, frame[k]);
      of_force[k] += body->inverse_kg + dot(moment, turned(moment));
      if (turns) of_torque[k] += dot(frame[k], turned(frame[k]));
    }
  };
  add_side(body_a, lever_a);
  add_side(body_b, lever_b);
  W.set(friction, present * of_force[0], present * greater(of_force[1], of_force[2]));
  W_spin = present * of_torque[0];
  W_roll = present * greater(of_torque[1], of_torque[2]);
  per_spin = inverse_or_zero(W_spin);
  per_roll = inverse_or_zero(W_roll);
  set_impulse(last_W + change_W, last_turn_W + change_turn_W);
}

// ---- velocities

inline void ContactPack::evaluate_contact_velocities(const SolverBody* body_a,
                                                     const SolverBody* body_b) {
  Lanes3 v = Lanes3::zero();
  const auto at = [](const Twist& twist, const Lanes3& lever) {
    return Lanes3::of(twist.v) + cross(Lanes3::of(twist.omega), lever);
  };
  if (body_a != nullptr) v = at(body_a->twist, lever_a);
  if (body_b != nullptr) v = v - at(body_b->twist, lever_b);
  y = to_frame(v) - target;
}

inline void ContactPack::evaluate_velocities(const SolverBody* body_a, const SolverBody* body_b) {
  evaluate_contact_velocities(body_a, body_b);
  if (!turns) return;
  Vector3 w = Vector3::Zero();
  if (body_a != nullptr) w += body_a->twist.omega;
  if (body_b != nullptr) w -= body_b->twist.omega;
  turn = to_frame(Lanes3::of(w));
}

inline void ContactPack::evaluate_rates(const Vector6* d_a, const Vector6* d_b) {
  Lanes3 v = Lanes3::zero();
  Vector3 w = Vector3::Zero();
  const auto at = [](const Vector6& d, const Lanes3& lever) {
    return Lanes3::of(d.head<3>()) + cross(Lanes3::of(d.tail<3>()), lever);
  };
  if (d_a != nullptr) {
    v = at(*d_a, lever_a);
    w += d_a->tail<3>();
  }
  if (d_b != nullptr) {
    v = v - at(*d_b, lever_b);
    w -= d_b->tail<3>();
  }
  rate = to_frame(v);
  if (turns) turn_rate = to_frame(Lanes3::of(w));
}

inline void ContactPack::move_along(double step) {
  y = y + spread(step) * rate;
  if (turns) turn = turn + spread(step) * turn_rate;
}

// ---- impulses

inline bool ContactPack::idle() const {
  if (any(x.x != 0)) return false;
  return !turns || !any((torque.x != 0) | (torque.y != 0) | (torque.z != 0));
}

inline void ContactPack::set_impulse(const Lanes3& impulse_W, const Lanes3& turn_W) {
  x = W.project(to_frame(impulse_W));
  torque = turns ? to_frame(turn_W) : Lanes3::zero();
}

inline void ContactPack::leave() {
  x = torque = Lanes3::zero();
  for (auto& row : gain.at) {
    for (Lanes& value : row) value = spread(0);
  }
  spin_gain = roll_gain_yy = roll_gain_yz = roll_gain_zz = spread(0);
}

/// The proximal term's share of each diagonal.
inline void ContactPack::set_softness(double epsilon, double hard_tangent) {
  const double around = epsilon + hard_tangent;
  D.set(friction, softness + epsilon * W.n, around * W.t);
  per_D_spin = per_spin / around;
  per_D_roll = per_roll / around;
}

inline void ContactPack::evaluate_impulses(const Lanes3& contact_v, const Lanes3& turn_v,
                                           bool exact, double hard_tangent) {
  const Lanes zero = spread(0);
  Lanes3 v = contact_v;
  // What opens, and bore nothing.
  const LaneMask opens = (v.x >= 0) & (centre.x == 0);
  if (exact && all(opens)) return leave();
  const Lanes across = root(v.y * v.y + v.z * v.z);
  if (exact) slip = friction * across;
  v.x += slip;
  // D x = (D - softness) centre - y, then into the cone.
  const Lanes stays_n = 1 - softness * D.per_n, stays_t = 1 - hard_tangent * W.t * D.per_t;
  const Lanes3 z = {stays_n * centre.x - D.per_n * v.x, stays_t * centre.y - D.per_t * v.y,
                    stays_t * centre.z - D.per_t * v.z};
  x = D.project(z, &gain);
  if (exact) {
    // The slip's own derivative.
    const Lanes scale = friction * inverse_or_zero(across);
    const Lanes by_y = scale * v.y, by_z = scale * v.z;
    for (auto& row : gain.at) {
      row[1] += by_y * row[0];
      row[2] += by_z * row[0];
    }
    x = {opens ? zero : x.x, opens ? zero : x.y, opens ? zero : x.z};
    for (auto& row : gain.at) {
      for (Lanes& value : row) value = opens ? zero : value;
    }
  }
  if (!turns) return;
  const Lanes bound = greater(centre.x, zero), most = spinning * bound;
  const Lanes spin = torque_centre.x - per_D_spin * turn_v.x;
  torque.x = bounded(spin, most);
  spin_gain = size_of(spin) < most ? per_D_spin : zero;
  // Onto a disc.
  const Lanes u = torque_centre.y - per_D_roll * turn_v.y,
              s = torque_centre.z - per_D_roll * turn_v.z;
  const Lanes radius = rolling * bound, before = root(u * u + s * s);
  const LaneMask within = before < radius;
  const Lanes per_before = inverse_or_zero(before);
  const Lanes ty = u * per_before, tz = s * per_before;
  const Lanes share = within ? spread(1) : radius * per_before;
  const Lanes around = per_D_roll * share;
  torque.y = share * u;
  torque.z = share * s;
  roll_gain_yy = within ? per_D_roll : around * tz * tz;
  roll_gain_zz = within ? per_D_roll : around * ty * ty;
  roll_gain_yz = within ? zero : -around * ty * tz;
}

inline double ContactPack::residual(double hard_tangent, double sliding_share, double lever) const {
  const Lanes across = root(y.y * y.y + y.z * y.z);
  const Lanes hard = hard_tangent * W.t;
  const Lanes3 v = {y.x + softness * x.x + friction * across, y.y + hard * x.y, y.z + hard * x.z};
  const Lanes3 off = x - W.project({x.x - W.per_n * v.x, x.y - W.per_t * v.y, x.z - W.per_t * v.z});
  // What slides fast needs no more than a share of its speed.
  Lanes out = greater(W.n * size_of(off.x), W.t * greater(size_of(off.y), size_of(off.z))) -
              sliding_share * across;
  if (turns) {
    const Lanes spin = torque.x - bounded(torque.x - per_spin * turn.x, spinning * x.x);
    out = greater(out, lever * W_spin * size_of(spin));
    const Lanes u = torque.y - per_roll * turn.y, s = torque.z - per_roll * turn.z;
    const Lanes radius = rolling * x.x, before = root(u * u + s * s);
    const Lanes share = before <= radius ? spread(1) : radius * inverse_or_zero(before);
    const Lanes du = torque.y - share * u, ds = torque.z - share * s;
    out = greater(out, lever * W_roll * root(du * du + ds * ds));
  }
  return greatest(out);
}

/// Sums over the lanes.
inline ContactPack::Net ContactPack::net_of(const Lanes3& p, const Lanes3& moment_a,
                                            const Lanes3& moment_b) {
  const Lanes head_a = sums(p.x, p.y, p.z, moment_a.x);
  const Lanes tails = sums(moment_a.y, moment_a.z, moment_b.y, moment_b.z);
  Lanes head_b = head_a;
  head_b[3] = sum(moment_b.x);
  return {Six::of(head_a, tails, false), Six::of(head_b, tails, true)};
}

inline ContactPack::Net ContactPack::net_of(const Lanes3& impulse) const {
  const Lanes3 p = from_frame(impulse);
  return net_of(p, cross(lever_a, p), cross(lever_b, p));
}

inline ContactPack::Net ContactPack::net() const {
  if (!turns) return net_of(x);
  const Lanes3 p = from_frame(x), t = from_frame(torque);
  return net_of(p, cross(lever_a, p) + t, cross(lever_b, p) + t);
}

inline int ContactPack::bearing() const {
  const LaneMask bears = ((x.x > 0) | (y.x < 0)) & (W.n > 0);
  return -static_cast<int>(bears[0] + bears[1] + bears[2] + bears[3]);
}

inline Lanes3 ContactPack::relax(double share) {
  const Lanes across = root(y.y * y.y + y.z * y.z);
  const Lanes v_n = y.x + softness * x.x + friction * across;
  const Lanes3 before = x;
  x = W.project({x.x - share * (W.per_n * v_n), x.y - share * (W.per_t * y.y),
                 x.z - share * (W.per_t * y.z)});
  return x - before;
}

inline Eigen::Matrix3d ContactPack::frame_of(int lane) const {
  Eigen::Matrix3d out;
  out << frame[0].at(lane).transpose(), frame[1].at(lane).transpose(),
      frame[2].at(lane).transpose();
  return out;
}

inline void ContactPack::add_gain(bool about_a, SixColumns& out) const {
  const Lanes3& lever = about_a ? lever_a : lever_b;
  // Rows of gain F and of gain (lever x F), and of the torques' gain times F.
  std::array<Lanes3, 3> forces, moments, torques;
  for (std::size_t k = 0; k < 3; ++k) {
    forces[k] = gain.at[k][0] * frame[0] + gain.at[k][1] * frame[1] + gain.at[k][2] * frame[2];
    moments[k] = cross(lever, forces[k]);
  }
  if (turns) {
    torques = {spin_gain * frame[0], roll_gain_yy * frame[1] + roll_gain_yz * frame[2],
               roll_gain_yz * frame[1] + roll_gain_zz * frame[2]};
  }
  const auto column = [this](const Lanes& by_0, const Lanes& by_1, const Lanes& by_2) {
    return by_0 * frame[0] + by_1 * frame[1] + by_2 * frame[2];
  };
  std::array<Lanes3, 6> top, bottom;
  top[0] = column(forces[0].x, forces[1].x, forces[2].x);
  top[1] = column(forces[0].y, forces[1].y, forces[2].y);
  top[2] = column(forces[0].z, forces[1].z, forces[2].z);
  top[3] = column(moments[0].x, moments[1].x, moments[2].x);
  top[4] = column(moments[0].y, moments[1].y, moments[2].y);
  top[5] = column(moments[0].z, moments[1].z, moments[2].z);
  for (std::size_t j = 0; j < 6; ++j) bottom[j] = cross(lever, top[j]);
  if (turns) {
    bottom[3] = bottom[3] + column(torques[0].x, torques[1].x, torques[2].x);
    bottom[4] = bottom[4] + column(torques[0].y, torques[1].y, torques[2].y);
    bottom[5] = bottom[5] + column(torques[0].z, torques[1].z, torques[2].z);
  }
  for (std::size_t j = 0; j < 6; j += 2) {
    const Lanes tails = sums(bottom[j].y, bottom[j].z, bottom[j + 1].y, bottom[j + 1].z);
    for (const std::size_t k : {j, j + 1}) {
      const Lanes head = sums(top[k].x, top[k].y, top[k].z, bottom[k].x);
      out.of[k] = out.of[k] + Six::of(head, tails, k > j);
    }
  }
}

}  // namespace aprsim::physics
