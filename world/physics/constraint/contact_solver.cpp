#include "world/physics/constraint/contact_solver.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "world/physics/collision/length.hpp"
#include "world/physics/collision/vector_clones.hpp"

namespace aprsim::physics {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

constexpr double kFirstEpsilon = 3e-3, kLeastEpsilon = 1e-8, kMostEpsilon = 1e-1;
constexpr double kEpsilonPerSpeed = 100;                     // [s/m], of the first residual
constexpr double kFast = 3e-3;                               // share that a good outer step leaves
constexpr double kShrink = 0.1, kMilder = 5, kGently = 0.2;  // changes of epsilon
constexpr double kInnerShare = 1e-2;  // of the residual, to which the inner problem is solved
constexpr int kMostInner = 12, kFewInner = 5;
constexpr int kMostLineSearch = 20, kMostHalvings = 6;
constexpr double kLeastProgress = 0.02;
// A search that drags on is content with less after so many Newton steps, with ten times as much
// after as many more.
constexpr double kPatient = 20, kTenfold = 12;
// What rests, and is driven by nothing, would gain energy from what is left over in each of very
// many steps [m/s]; it is solved to a share of the tolerance, for a Newton step now and then.
constexpr double kResting = 1e-4, kAtRest = 0.1;
// Impulses that are farther off than that are relaxed first, for so many rounds [m/s].
constexpr double kBlow = 1e-4;
constexpr int kRounds = 10;
constexpr double kSlidingShare = 1e-6;
constexpr double kHardTangent = 1e-9;  ///< softness of friction, of W
constexpr double kLever = 0.01;        ///< [m] at which angular velocities count in the residual

/// Two directions across n.
Matrix3 frame_of(const Vector3& n) {
  Matrix3 frame;
  // Across the axis that is least along n.
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  const Vector3 t1 = n.cross(Vector3::Unit(least)).normalized();
  frame.row(0) = n.transpose();
  frame.row(1) = t1.transpose();
  frame.row(2) = n.cross(t1).transpose();
  return frame;
}

/// frame' gain frame.
inline Matrix3 rotated(const Matrix3& frame, const Matrix3& gain) {
  Matrix3 half;
  for (int j = 0; j < 3; ++j) {
    half.col(j) = gain.col(0) * frame(0, j) + gain.col(1) * frame(1, j) + gain.col(2) * frame(2, j);
  }
  Matrix3 out;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      out(i, j) = frame(0, i) * half(0, j) + frame(1, i) * half(1, j) + frame(2, i) * half(2, j);
    }
  }
  return out;
}

/// Adds J gain J', of the columns J = (direction; moment).
inline void add_contact_gain(const Eigen::Matrix<double, 6, 3>& J, const Matrix3& gain,
                             BlockLu::Block& out) {
  for (int j = 0; j < 6; ++j) {
    const double x = gain(0, 0) * J(j, 0) + gain(0, 1) * J(j, 1) + gain(0, 2) * J(j, 2);
    const double y = gain(1, 0) * J(j, 0) + gain(1, 1) * J(j, 1) + gain(1, 2) * J(j, 2);
    const double z = gain(2, 0) * J(j, 0) + gain(2, 1) * J(j, 1) + gain(2, 2) * J(j, 2);
    double column[6];
    for (int i = 0; i < 6; ++i) column[i] = out(i, j);
    for (int i = 0; i < 6; ++i) column[i] += J(i, 0) * x;
    for (int i = 0; i < 6; ++i) column[i] += J(i, 1) * y;
    for (int i = 0; i < 6; ++i) column[i] += J(i, 2) * z;
    for (int i = 0; i < 6; ++i) out(i, j) = column[i];
  }
}

/// S T, where T = (1, -[d]; 0, 1) takes the levers from one centre to another by d.
inline BlockLu::Block shifted_columns(const BlockLu::Block& S, const Vector3& d) {
  BlockLu::Block out = S;
  for (int i = 0; i < 6; ++i) {
    out(i, 3) += S(i, 2) * d.y() - S(i, 1) * d.z();
    out(i, 4) += S(i, 0) * d.z() - S(i, 2) * d.x();
    out(i, 5) += S(i, 1) * d.x() - S(i, 0) * d.y();
  }
  return out;
}

/// T' S.
inline BlockLu::Block shifted_rows(const BlockLu::Block& S, const Vector3& d) {
  BlockLu::Block out = S;
  for (int j = 0; j < 6; ++j) {
    out(3, j) += S(2, j) * d.y() - S(1, j) * d.z();
    out(4, j) += S(0, j) * d.z() - S(2, j) * d.x();
    out(5, j) += S(1, j) * d.x() - S(0, j) * d.y();
  }
  return out;
}

/// Adds a b'.
inline void add_outer(const BlockLu::Vector6& a, const BlockLu::Vector6& b, BlockLu::Block& out) {
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) out(i, j) += a(i) * b(j);
  }
}

/// Projection of a vector onto a disc.
void project_disc(double& y, double& z, double radius, double gain, double* g_yy, double* g_yz,
                  double* g_zz) {
  const double before = length(y, z);
  if (before <= radius) {
    *g_yy = *g_zz = gain;
    *g_yz = 0;
    return;
  }
  const double share = radius / before;
  const double ty = y / before, tz = z / before;
  *g_yy = gain * share * tz * tz;
  *g_zz = gain * share * ty * ty;
  *g_yz = -gain * share * ty * tz;
  y *= share;
  z *= share;
}

/// The residual that does after so many Newton steps.
double enough_m_s(const ContactSolver::Settings& settings, int iterations) {
  if (iterations <= kPatient) return settings.tolerance_m_s;
  const double grown = settings.tolerance_m_s * std::pow(10, (iterations - kPatient) / kTenfold);
  return std::max(settings.tolerance_m_s, std::min(settings.coarsest_m_s, grown));
}

}  // namespace

inline void ContactSolver::Cone::set(double friction, double metric_n, double metric_t) {
  mu = friction;
  n = metric_n;
  t = metric_t;
  per_n = n > 0 ? 1 / n : 0;
  per_t = t > 0 ? 1 / t : 0;
  leaning = mu * t * per_n;
  share = 1 / (1 + mu * leaning);
}

/// Projection of z onto the cone in its metric; `gain`, if wanted, is its derivative times the
/// metric's inverse.
inline Vector3 ContactSolver::project(const Cone& cone, const Vector3& z, Matrix3* gain) {
  const double across = length(z.y(), z.z());
  if (z.x() >= 0 && across <= cone.mu * z.x()) {
    if (gain) {
      gain->setZero();
      gain->diagonal() << cone.per_n, cone.per_t, cone.per_t;
    }
    return z;
  }
  if (z.x() <= -cone.leaning * across) {
    if (gain) gain->setZero();
    return Vector3::Zero();
  }
  // Onto the cone's generator, as seen in the metric.
  const double xn = cone.share * (z.x() + cone.leaning * across), xt = cone.mu * xn;
  const double per_across = across > 0 ? 1 / across : 0;
  const double ty = across > 0 ? z.y() * per_across : 1, tz = z.z() * per_across;
  if (gain) {
    // Along the cone's generator, and around the cone.
    const double nn = cone.share * cone.per_n, nt = cone.mu * nn, tt = cone.mu * nt,
                 around = xt * per_across * cone.per_t;
    Matrix3& g = *gain;
    g(0, 0) = nn;
    g(0, 1) = g(1, 0) = nt * ty;
    g(0, 2) = g(2, 0) = nt * tz;
    g(1, 1) = tt * ty * ty + around * tz * tz;
    g(2, 2) = tt * tz * tz + around * ty * ty;
    g(1, 2) = g(2, 1) = (tt - around) * ty * tz;
  }
  return {xn, xt * ty, xt * tz};
}

inline void ContactSolver::Contact::set_impulse(const Vector3& impulse_ns,
                                                const Vector3& turn_nms) {
  x = project(W, frame * impulse_ns, nullptr);
  if (turns) torque = frame * turn_nms;
}

void ContactSolver::clear() {
  bodies_.clear();
  moving_.clear();
  rows_.clear();
  contacts_.clear();
}

int ContactSolver::add_body(double mass_kg, const Matrix3& inertia, const Vector3& com,
                            const Twist& free, const Twist& now) {
  Body body;
  body.kg = mass_kg;
  body.inverse_kg = 1 / mass_kg;
  body.inertia = inertia;
  body.inverse_inertia = inertia.inverse();
  body.com = com;
  body.free = free;
  body.twist = now;
  body.unknown = static_cast<int>(moving_.size());
  moving_.push_back(static_cast<int>(bodies_.size()));
  bodies_.push_back(body);
  return static_cast<int>(bodies_.size()) - 1;
}

int ContactSolver::add_kinematic(const Vector3& com, const Twist& twist) {
  Body body;
  body.com = com;
  body.free = body.twist = twist;
  bodies_.push_back(body);
  return static_cast<int>(bodies_.size()) - 1;
}

int ContactSolver::add_row(const Side& a, const Side& b, double target, double softness,
                           double lo_ns, double hi_ns, const Guess<double>& guess_ns) {
  Row row;
  row.a = a;
  row.b = b;
  row.target = target;
  row.softness = softness;
  if (a.linear.isZero(0) && b.linear.isZero(0)) row.lever = kLever;
  row.lo = lo_ns;
  row.hi = hi_ns;
  row.now.x = std::clamp(guess_ns.last + guess_ns.change, lo_ns, hi_ns);
  row.other_guess = std::clamp(guess_ns.last, lo_ns, hi_ns);
  for (const Side* side : {&row.a, &row.b}) {
    if (side->body == kFixed) continue;
    const Body& body = at(side->body);
    row.W += body.inverse_kg * side->linear.squaredNorm() +
             side->angular.dot(body.inverse_inertia * side->angular);
  }
  rows_.push_back(row);
  return static_cast<int>(rows_.size()) - 1;
}

APRSIM_VECTOR_CLONES int ContactSolver::add_contact(const ContactDescription& in) {
  Contact& contact = contacts_.emplace_back();
  contact.a = in.a;
  contact.b = in.b;
  contact.frame = frame_of(in.n);
  contact.friction = in.friction;
  contact.spinning = in.spinning_m;
  contact.rolling = in.rolling_m;
  contact.turns = in.spinning_m > 0 || in.rolling_m > 0;
  contact.target = contact.frame * in.target_v;
  contact.softness = in.softness_m_s_ns;
  // The diagonal of J M^-1 J'.
  Vector3 W = Vector3::Zero(), W_turn = Vector3::Zero();
  for (const auto& [number, lever] :
       {std::pair(in.a, &contact.lever_a), std::pair(in.b, &contact.lever_b)}) {
    if (number == kFixed) continue;
    const Body& body = at(number);
    *lever = in.p - body.com;
    if (body.unknown < 0) continue;
    const bool first = contact.J.isZero(0);
    for (int k = 0; k < 3; ++k) {
      const Vector3 d = contact.frame.row(k).transpose();
      const Vector3 moment = lever->cross(d);
      if (first) {
        contact.J.col(k).head<3>() = d;
        contact.J.col(k).tail<3>() = moment;
      }
      W(k) += body.inverse_kg + moment.dot(body.inverse_inertia * moment);
      if (contact.turns) W_turn(k) += d.dot(body.inverse_inertia * d);
    }
  }
  contact.W.set(in.friction, W(0), std::max(W(1), W(2)));
  contact.W_spin = W_turn(0);
  contact.W_roll = std::max(W_turn(1), W_turn(2));
  contact.set_impulse(in.impulse_ns.last + in.impulse_ns.change,
                      in.turn_nms.last + in.turn_nms.change);
  contact.last_ns = in.impulse_ns.last;
  contact.last_turn_nms = in.turn_nms.last;
  return static_cast<int>(contacts_.size()) - 1;
}

Vector3 ContactSolver::contact_impulse_ns(int contact) const {
  const Contact& c = contacts_[index(contact)];
  return c.frame.transpose() * c.x;
}

Vector3 ContactSolver::contact_turn_nms(int contact) const {
  const Contact& c = contacts_[index(contact)];
  return c.turns ? Vector3(c.frame.transpose() * c.torque) : Vector3::Zero();
}

// ---- the problem

/// Which bodies each row and contact couples, and the matrix's structure.
void ContactSolver::prepare() {
  pairs_.clear();
  // Contacts of the same two bodies stand together.
  std::pair<int, int> last(-1, -1);
  const auto pair_of = [this, &last](int a, int b) {
    const int i = a == kFixed ? -1 : at(a).unknown, k = b == kFixed ? -1 : at(b).unknown;
    if (i < 0 || k < 0 || i == k) return -1;
    if (std::pair(i, k) != last || pairs_.empty()) pairs_.emplace_back(i, k);
    last = {i, k};
    return static_cast<int>(pairs_.size()) - 1;
  };
  for (Row& row : rows_) row.place = pair_of(row.a.body, row.b.body);
  for (Contact& contact : contacts_) contact.place = pair_of(contact.a, contact.b);
  matrix_.analyse(static_cast<int>(moving_.size()), pairs_);
  gradient_.resize(moving_.size());
  direction_.resize(moving_.size());
  rows_kept_ = false;
}

inline void ContactSolver::push(int number, const Vector3& impulse, const Vector3& moment) {
  if (number == kFixed) return;
  Body& body = at(number);
  if (body.unknown < 0) return;
  body.twist.v += body.inverse_kg * impulse;
  body.twist.omega += body.inverse_inertia * moment;
}

inline Vector3 ContactSolver::velocity_at(int number, const Vector3& lever) const {
  if (number == kFixed) return Vector3::Zero();
  const Twist& twist = at(number).twist;
  return twist.v + twist.omega.cross(lever);
}

inline double ContactSolver::velocity_of(const Side& side) const {
  if (side.body == kFixed) return 0;
  const Twist& twist = at(side.body).twist;
  return side.linear.dot(twist.v) + side.angular.dot(twist.omega);
}

/// V = V_free + M^-1 J' x.
APRSIM_VECTOR_CLONES void ContactSolver::velocities_from_impulses() {
  for (const int i : moving_) {
    Body& body = at(i);
    body.twist = body.free;
  }
  for (const Row& row : rows_) {
    if (row.now.x == 0) continue;
    push(row.a.body, row.now.x * row.a.linear, row.now.x * row.a.angular);
    push(row.b.body, row.now.x * row.b.linear, row.now.x * row.b.angular);
  }
  for (const Contact& c : contacts_) {
    if (c.idle()) continue;
    const Vector3 p = c.frame.transpose() * c.x;
    Vector3 torque = Vector3::Zero();
    if (c.turns) torque = c.frame.transpose() * c.torque;
    push(c.a, p, c.lever_a.cross(p) + torque);
    push(c.b, -p, -c.lever_b.cross(p) - torque);
  }
}

/// y = J V - target, of every row and contact.
APRSIM_VECTOR_CLONES void ContactSolver::evaluate_velocities() {
  for (Row& row : rows_) row.y = velocity_of(row.a) + velocity_of(row.b) - row.target;
  for (Contact& c : contacts_) {
    c.y = c.frame * (velocity_at(c.a, c.lever_a) - velocity_at(c.b, c.lever_b)) - c.target;
    if (!c.turns) continue;
    Vector3 turn = Vector3::Zero();
    if (c.a != kFixed) turn += at(c.a).twist.omega;
    if (c.b != kFixed) turn -= at(c.b).twist.omega;
    c.turn = c.frame * turn;
  }
}

/// Which contacts are of bodies that rows drive.
void ContactSolver::note_driven() {
  for (const Row& row : rows_) {
    for (const Side* side : {&row.a, &row.b}) {
      if (side->body != kFixed) at(side->body).driven = true;
    }
  }
  for (Contact& c : contacts_) {
    c.loose = !(c.a != kFixed && at(c.a).driven) && !(c.b != kFixed && at(c.b).driven);
  }
}

/// How far each row and contact is from complementarity: the natural map, in units of velocity.
/// Leaves the velocities of the impulses in place; swap_velocities() brings the others back.
APRSIM_VECTOR_CLONES ContactSolver::Residual ContactSolver::residual() {
  for (const int i : moving_) at(i).searched = at(i).twist;
  velocities_from_impulses();
  evaluate_velocities();
  double rows = 0, driven = 0, loose = 0;
  for (const Row& row : rows_) {
    if (!(row.W > 0)) continue;
    const double y = row.y + row.softness * row.now.x;
    const double x = std::clamp(row.now.x - y / row.W, row.lo, row.hi);
    rows = std::max(rows, row.lever * row.W * std::abs(row.now.x - x));
  }
  for (const Contact& c : contacts_) {
    if (!(c.W.n > 0) || (c.y.x() >= 0 && c.idle())) continue;
    Vector3 y = c.y;
    const double across = length(y.y(), y.z());
    y.x() += c.softness * c.x.x() + c.friction * across;
    y.tail<2>() += kHardTangent * c.W.t * c.x.tail<2>();
    const Vector3 z = c.x - Vector3(c.W.per_n * y.x(), c.W.per_t * y.y(), c.W.per_t * y.z());
    const Vector3 off = c.x - project(c.W, z, nullptr);
    // What slides fast needs no more than a share of its speed.
    const double slack = kSlidingShare * across;
    double own = std::max({c.W.n * std::abs(off.x()), c.W.t * std::abs(off.y()),
                           c.W.t * std::abs(off.z())}) -
                 slack;
    if (c.turns && c.spinning > 0) {
      const double bound = c.spinning * c.x.x();
      const double x = std::clamp(c.torque.x() - c.turn.x() / c.W_spin, -bound, bound);
      own = std::max(own, kLever * c.W_spin * std::abs(c.torque.x() - x));
    }
    if (c.turns && c.rolling > 0) {
      double u = c.torque.y() - c.turn.y() / c.W_roll, w = c.torque.z() - c.turn.z() / c.W_roll;
      double unused[3];
      project_disc(u, w, c.rolling * c.x.x(), 1, unused, unused + 1, unused + 2);
      own = std::max(own, kLever * c.W_roll * length(c.torque.y() - u, c.torque.z() - w));
    }
    (c.loose ? loose : driven) = std::max(c.loose ? loose : driven, own);
  }
  return {.all_m_s = std::max({rows, driven, loose}),
          .excess_m_s = std::max({rows, driven, loose - slack_m_s_})};
}

void ContactSolver::swap_velocities() {
  for (const int i : moving_) at(i).twist = at(i).searched;
}

// ---- the outer iteration

/// The proximal term's share of each diagonal.
void ContactSolver::set_softness(double epsilon) {
  for (Row& row : rows_) row.D = row.softness + epsilon * row.W;
  for (Contact& c : contacts_) {
    const double around = epsilon + kHardTangent;
    c.D.set(c.friction, c.softness + epsilon * c.W.n, around * c.W.t);
    c.D_spin = around * c.W_spin;
    c.D_roll = around * c.W_roll;
  }
}

/// Back to the centres, and to their velocities.
void ContactSolver::return_to_centres() {
  for (Row& row : rows_) row.now.x = row.now.centre;
  for (Contact& c : contacts_) {
    c.x = c.centre;
    c.torque = c.torque_centre;
  }
  velocities_from_impulses();
  evaluate_velocities();
}

/// The present impulses become the centres, the present slip the correction.
void ContactSolver::recentre() {
  for (Row& row : rows_) row.now.centre = row.now.x;
  for (Contact& c : contacts_) {
    c.centre = c.x;
    c.torque_centre = c.torque;
  }
  recentre_slip();
}

void ContactSolver::recentre_slip() {
  for (Contact& c : contacts_) c.slip = c.friction * length(c.y.y(), c.y.z());
}

void ContactSolver::take_last() {
  for (Row& row : rows_) row.now.x = row.other_guess;
  for (Contact& c : contacts_) c.set_impulse(c.last_ns, c.last_turn_nms);
}

ContactSolver::Residual ContactSolver::begin_from_better_guess(double enough_m_s) {
  const Residual first = residual();
  if (first.excess_m_s <= enough_m_s) return first;
  keep_best();
  take_last();
  const Residual second = residual();
  if (second.excess_m_s < first.excess_m_s) return second;
  take_best();
  velocities_from_impulses();
  evaluate_velocities();
  return first;
}

/// One round of relaxation, pair of bodies by pair: nonlinear Gauss-Seidel. The contacts of a pair
/// share the load of the same velocities (as mass splitting does: Tonge et al. 2012); in turns the
/// first ones would take it, and how what slides turns depends on how evenly it is borne.
APRSIM_VECTOR_CLONES void ContactSolver::relax() {
  for (std::size_t first = 0, end = 0; first < contacts_.size(); first = end) {
    const Contact& of = contacts_[first];
    int bearing = 0;
    for (end = first; end < contacts_.size(); ++end) {
      Contact& c = contacts_[end];
      if (c.a != of.a || c.b != of.b) break;
      c.y = c.frame * (velocity_at(c.a, c.lever_a) - velocity_at(c.b, c.lever_b)) - c.target;
      bearing += c.x.x() > 0 || c.y.x() < 0;
    }
    if (bearing == 0) continue;
    const double share = 1.0 / bearing;
    for (std::size_t i = first; i < end; ++i) {
      Contact& c = contacts_[i];
      if (!(c.W.n > 0)) continue;
      Vector3 y = c.y;
      y.x() += c.softness * c.x.x() + c.friction * length(y.y(), y.z());
      const Vector3 way(c.W.per_n * y.x(), c.W.per_t * y.y(), c.W.per_t * y.z());
      const Vector3 by = project(c.W, c.x - share * way, nullptr) - c.x;
      if (by.isZero(0)) continue;
      c.x += by;
      const Vector3 p = c.frame.transpose() * by;
      push(c.a, p, c.lever_a.cross(p));
      push(c.b, -p, -c.lever_b.cross(p));
    }
  }
}

/// After a blow a few rounds find out cheaply which contacts bear it, and which slip. What rows
/// drive is not relaxed: how firmly a hand holds depends on how its contacts share the load, which
/// has to change as little as possible.
ContactSolver::Residual ContactSolver::relax_blow(const Residual& first) {
  keep_best();
  for (int i = 0; i < kRounds; ++i) relax();
  const Residual relaxed = residual();
  if (relaxed.excess_m_s < first.excess_m_s) return relaxed;
  take_best();
  velocities_from_impulses();
  evaluate_velocities();
  return first;
}

bool ContactSolver::rests() const {
  return rows_.empty() && std::ranges::all_of(moving_, [this](int body) {
           const Twist& twist = at(body).twist;
           return std::max(twist.v.norm(), kLever * twist.omega.norm()) < kResting;
         });
}

ContactSolver::Outcome ContactSolver::solve(const Settings& settings) {
  if (moving_.empty()) return {.converged = true};
  note_driven();
  slack_m_s_ = std::max(0.0, settings.loose_m_s - settings.tolerance_m_s);
  Settings own = settings;
  if (rests()) own.tolerance_m_s *= kAtRest;
  Residual present = begin_from_better_guess(own.tolerance_m_s);
  const bool blow = rows_.empty() && present.all_m_s > kBlow;
  if (blow) present = relax_blow(present);
  if (present.excess_m_s <= own.tolerance_m_s) {
    return {
        .converged = true, .as_guessed = !blow && rows_.empty(), .residual_m_s = present.all_m_s};
  }
  return iterate(present, own);
}

ContactSolver::Outcome ContactSolver::iterate(Residual first, const Settings& settings) {
  prepare();
  Outcome outcome;
  Residual present = first;
  double best = present.excess_m_s, before = best;
  keep_best();
  double shrink = kShrink;
  double epsilon = std::clamp(kEpsilonPerSpeed * present.all_m_s, kFirstEpsilon, kMostEpsilon);
  while (outcome.iterations < settings.most_iterations) {
    set_softness(epsilon);
    recentre();
    // The problem in V, with the slip that follows; where that does not lead on, the convex one.
    const double enough = enough_m_s(settings, outcome.iterations);
    const double wanted = std::max(0.1 * enough, kInnerShare * present.all_m_s);
    int inner = 0;
    bool good = true;
    exact_ = true;
    evaluate_impulses(0);
    Gradient gradient = find_gradient();
    while (inner < kMostInner && outcome.iterations < settings.most_iterations) {
      if (gradient.speed_m_s <= wanted && inner > 0) break;
      if (!find_direction()) {
        good = false;
        break;
      }
      ++inner;
      ++outcome.iterations;
      find_rates();
      if (exact_ && backtrack(gradient)) continue;
      if (exact_ && epsilon < kMostEpsilon) {
        good = false;
        break;
      }
      if (exact_) {
        exact_ = false;
        recentre_slip();
        evaluate_impulses(0);
        gradient = find_gradient();
        continue;
      }
      move_along(line_search());
      evaluate_impulses(0);
      gradient = find_gradient();
    }
    if ((!good || inner >= kMostInner) && epsilon < kMostEpsilon) {
      // From where it began, less stiff.
      return_to_centres();
      epsilon = std::min(kMostEpsilon, kMilder * epsilon);
      shrink = kGently;
      continue;
    }
    present = residual();
    const bool done = present.excess_m_s <= enough_m_s(settings, outcome.iterations);
    if (present.excess_m_s < best && !done) {
      best = present.excess_m_s;
      keep_best();
    }
    if (done) {
      outcome.converged = true;
      outcome.residual_m_s = present.all_m_s;
      return outcome;
    }
    swap_velocities();
    evaluate_velocities();
    const double fell = present.excess_m_s / before;
    before = present.excess_m_s;
    if (inner <= kFewInner && fell > kFast) epsilon = std::max(kLeastEpsilon, shrink * epsilon);
  }
  take_best();
  const Residual last = residual();
  outcome.residual_m_s = last.all_m_s;
  outcome.converged = last.excess_m_s <= enough_m_s(settings, outcome.iterations);
  return outcome;
}

void ContactSolver::keep_best() {
  best_rows_.resize(rows_.size());
  best_contacts_.resize(contacts_.size());
  best_torques_.resize(contacts_.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) best_rows_[i] = rows_[i].now.x;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    best_contacts_[i] = contacts_[i].x;
    best_torques_[i] = contacts_[i].torque;
  }
}

void ContactSolver::take_best() {
  for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].now.x = best_rows_[i];
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    contacts_[i].x = best_contacts_[i];
    contacts_[i].torque = best_torques_[i];
  }
}

// ---- the convex problem

/// Impulses that belong to the velocities y + along * rate, and their derivatives.
APRSIM_VECTOR_CLONES void ContactSolver::evaluate_impulses(double along) {
  for (Row& row : rows_) {
    if (!(row.D > 0)) continue;
    const double y = row.y + along * row.rate;
    // D x = (D - softness) centre - y, then within bounds.
    const double z = ((row.D - row.softness) * row.now.centre - y) / row.D;
    row.now.x = std::clamp(z, row.lo, row.hi);
    row.now.gain = z > row.lo && z < row.hi ? 1 / row.D : 0;
  }
  for (Contact& c : contacts_) {
    if (!(c.D.n > 0)) continue;
    Vector3 y = c.y + along * c.rate;
    if (exact_ && y.x() >= 0 && c.centre.isZero(0)) {
      c.leave();
      continue;
    }
    const double across = length(y.y(), y.z());
    if (exact_) c.slip = c.friction * across;
    y.x() += c.slip;
    // D x = (D - softness) centre - y, then into the cone.
    const double stays_n = 1 - c.softness * c.D.per_n,
                 stays_t = 1 - kHardTangent * c.W.t * c.D.per_t;
    const Vector3 z(stays_n * c.centre.x() - c.D.per_n * y.x(),
                    stays_t * c.centre.y() - c.D.per_t * y.y(),
                    stays_t * c.centre.z() - c.D.per_t * y.z());
    c.x = project(c.D, z, &c.gain);
    if (exact_ && across > 0) {
      // The slip's own derivative.
      c.gain.col(1) += c.friction * y.y() / across * c.gain.col(0);
      c.gain.col(2) += c.friction * y.z() / across * c.gain.col(0);
    }
    if (!c.turns) continue;
    const Vector3 turn = c.turn + along * c.turn_rate;
    const double bound = std::max(0.0, c.centre.x());
    c.turn_gain.setZero();
    if (c.spinning > 0) {
      const double D = c.D_spin;
      const double spin = c.torque_centre.x() - turn.x() / D;
      c.torque.x() = std::clamp(spin, -c.spinning * bound, c.spinning * bound);
      if (spin == c.torque.x()) c.turn_gain(0, 0) = 1 / D;
    }
    if (c.rolling > 0) {
      const double D = c.D_roll;
      c.torque.y() = c.torque_centre.y() - turn.y() / D;
      c.torque.z() = c.torque_centre.z() - turn.z() / D;
      double yy = 0, yz = 0, zz = 0;
      project_disc(c.torque.y(), c.torque.z(), c.rolling * bound, 1 / D, &yy, &yz, &zz);
      c.turn_gain(1, 1) = yy;
      c.turn_gain(1, 2) = c.turn_gain(2, 1) = yz;
      c.turn_gain(2, 2) = zz;
    }
  }
}

/// M (V - V_free) - J' x; returns the largest change of velocity that it stands for.
APRSIM_VECTOR_CLONES ContactSolver::Gradient ContactSolver::find_gradient() {
  Gradient out;
  for (const int i : moving_) {
    const Body& body = at(i);
    Vector6& g = gradient_[index(body.unknown)];
    g.head<3>() = body.kg * (body.twist.v - body.free.v);
    g.tail<3>() = body.inertia * (body.twist.omega - body.free.omega);
  }
  const auto pull = [this](int number, const Vector3& impulse, const Vector3& moment) {
    if (number == kFixed || at(number).unknown < 0) return;
    Vector6& g = gradient_[index(at(number).unknown)];
    g.head<3>() -= impulse;
    g.tail<3>() -= moment;
  };
  for (const Row& row : rows_) {
    pull(row.a.body, row.now.x * row.a.linear, row.now.x * row.a.angular);
    pull(row.b.body, row.now.x * row.b.linear, row.now.x * row.b.angular);
  }
  for (const Contact& c : contacts_) {
    if (c.idle()) continue;
    const Vector3 p = c.frame.transpose() * c.x;
    Vector3 torque = Vector3::Zero();
    if (c.turns) torque = c.frame.transpose() * c.torque;
    pull(c.a, p, c.lever_a.cross(p) + torque);
    pull(c.b, -p, -c.lever_b.cross(p) - torque);
  }
  for (const int i : moving_) {
    const Body& body = at(i);
    const Vector6& g = gradient_[index(body.unknown)];
    const Vector3 dv = body.inverse_kg * g.head<3>(), dw = body.inverse_inertia * g.tail<3>();
    out.energy += g.head<3>().dot(dv) + g.tail<3>().dot(dw);
    out.speed_m_s = std::max({out.speed_m_s, dv.norm(), kLever * dw.norm()});
  }
  return out;
}

/// (M + J' G J) d = -gradient.
APRSIM_VECTOR_CLONES bool ContactSolver::find_direction() {
  fill_rows();
  fill_contacts();
  if (!matrix_.factorise()) return false;
  for (std::size_t i = 0; i < gradient_.size(); ++i) direction_[i] = -gradient_[i];
  return matrix_.solve(direction_);
}

/// Contacts of the same two bodies are added up about the first that moves, then shifted.
APRSIM_VECTOR_CLONES void ContactSolver::fill_contacts() {
  BlockLu::Block sum;
  for (std::size_t first = 0, end = 0; first < contacts_.size(); first = end) {
    const Contact& of = contacts_[first];
    const int a = of.a == kFixed ? -1 : at(of.a).unknown,
              b = of.b == kFixed ? -1 : at(of.b).unknown;
    sum.setZero();
    bool any = false;
    for (end = first; end < contacts_.size(); ++end) {
      const Contact& c = contacts_[end];
      if (c.a != of.a || c.b != of.b) break;
      if (c.gain(0, 0) == 0 && c.gain(1, 1) == 0) continue;
      any = true;
      add_contact_gain(c.J, c.gain, sum);
      if (c.turns && !c.turn_gain.isZero(0)) {
        sum.bottomRightCorner<3, 3>() += rotated(c.frame, c.turn_gain);
      }
    }
    if (!any) continue;
    matrix_.diagonal(a >= 0 ? a : b) += sum;
    if (of.place < 0) continue;
    // Of b: the same impulses, and moments about its own centre.
    const Vector3 shift = of.lever_b - of.lever_a;
    const auto place = matrix_.place(index(of.place));
    const BlockLu::Block right = shifted_columns(sum, shift);
    matrix_.forward(place) -= right;
    matrix_.backward(place) -= shifted_rows(sum, shift);
    matrix_.diagonal(b) += shifted_rows(right, shift);
  }
}

/// The part of bodies and rows, as long as no bound of a row comes or goes the same for a centre.
void ContactSolver::fill_rows() {
  bool same = rows_kept_;
  for (const Row& row : rows_) same = same && row.now.gain == row.kept_gain;
  if (same) return matrix_.restore();
  matrix_.set_zero();
  for (const int i : moving_) {
    const Body& body = at(i);
    auto& block = matrix_.diagonal(body.unknown);
    block.topLeftCorner<3, 3>().diagonal().setConstant(body.kg);
    block.bottomRightCorner<3, 3>() = body.inertia;
  }
  for (Row& row : rows_) {
    row.kept_gain = row.now.gain;
    if (row.now.gain == 0) continue;
    Vector6 j[2], scaled[2];
    j[0] << row.a.linear, row.a.angular;
    j[1] << row.b.linear, row.b.angular;
    const int unknown[2] = {row.a.body == kFixed ? -1 : at(row.a.body).unknown,
                            row.b.body == kFixed ? -1 : at(row.b.body).unknown};
    for (int k = 0; k < 2; ++k) scaled[k] = row.now.gain * j[k];
    for (int k = 0; k < 2; ++k) {
      if (unknown[k] >= 0) add_outer(scaled[k], j[k], matrix_.diagonal(unknown[k]));
    }
    if (unknown[0] >= 0 && unknown[0] == unknown[1]) {
      add_outer(scaled[0], j[1], matrix_.diagonal(unknown[0]));
      add_outer(scaled[1], j[0], matrix_.diagonal(unknown[0]));
    }
    if (row.place < 0) continue;
    const auto place = matrix_.place(index(row.place));
    add_outer(scaled[0], j[1], matrix_.forward(place));
    add_outer(scaled[1], j[0], matrix_.backward(place));
  }
  matrix_.keep();
  rows_kept_ = true;
}

/// Derivative of the convex function along the direction.
double ContactSolver::slope(double along) {
  double sum = 0;
  for (const int i : moving_) {
    const Body& body = at(i);
    const Vector6& d = direction_[index(body.unknown)];
    const Vector3 dv = body.twist.v - body.free.v + along * d.head<3>();
    const Vector3 dw = body.twist.omega - body.free.omega + along * d.tail<3>();
    sum += body.kg * d.head<3>().dot(dv) + d.tail<3>().dot(body.inertia * dw);
  }
  evaluate_impulses(along);
  for (const Row& row : rows_) sum -= row.rate * row.now.x;
  for (const Contact& c : contacts_) {
    sum -= c.rate.dot(c.x);
    if (c.turns) sum -= c.turn_rate.dot(c.torque);
  }
  return sum;
}

APRSIM_VECTOR_CLONES void ContactSolver::find_rates() {
  const auto d_of = [this](int number) -> const Vector6* {
    if (number == kFixed || at(number).unknown < 0) return nullptr;
    return &direction_[index(at(number).unknown)];
  };
  for (Row& row : rows_) {
    row.rate = 0;
    for (const Side* side : {&row.a, &row.b}) {
      if (const Vector6* d = d_of(side->body)) {
        row.rate += side->linear.dot(d->head<3>()) + side->angular.dot(d->tail<3>());
      }
    }
  }
  for (Contact& c : contacts_) {
    Vector3 rate = Vector3::Zero(), turn = Vector3::Zero();
    if (const Vector6* d = d_of(c.a)) {
      rate += d->head<3>() + d->tail<3>().cross(c.lever_a);
      turn += d->tail<3>();
    }
    if (const Vector6* d = d_of(c.b)) {
      rate -= d->head<3>() + d->tail<3>().cross(c.lever_b);
      turn -= d->tail<3>();
    }
    c.rate = c.frame * rate;
    c.turn_rate = c.frame * turn;
  }
}

void ContactSolver::move_along(double step) {
  for (const int i : moving_) {
    Body& body = at(i);
    const Vector6& d = direction_[index(body.unknown)];
    body.twist.v += step * d.head<3>();
    body.twist.omega += step * d.tail<3>();
  }
  for (Row& row : rows_) row.y += step * row.rate;
  for (Contact& c : contacts_) {
    c.y += step * c.rate;
    if (c.turns) c.turn += step * c.turn_rate;
  }
}

/// The longest of a few steps that brings the equations nearer to zero; false = none, and nothing
/// has changed.
bool ContactSolver::backtrack(Gradient& gradient) {
  double step = 1, moved = 0;
  for (int i = 0; i < kMostHalvings; ++i, step *= 0.5) {
    move_along(step - moved);
    moved = step;
    evaluate_impulses(0);
    const Gradient next = find_gradient();
    if (next.energy <= (1 - kLeastProgress * step) * gradient.energy) {
      gradient = next;
      return true;
    }
  }
  move_along(-moved);
  return false;
}

/// The least value along the direction: the zero of a rising slope, by regula falsi (Illinois).
double ContactSolver::line_search() {
  double lo = 0, slope_lo = slope(0), hi = 1, slope_hi = slope(1);
  const double enough = 0.1 * std::abs(slope_lo);
  if (std::abs(slope_hi) <= 2 * enough || slope_hi <= 0) return 1;
  for (int i = 0; i < kMostLineSearch; ++i) {
    const double middle = (lo * slope_hi - hi * slope_lo) / (slope_hi - slope_lo);
    const double slope_middle = slope(middle);
    if (std::abs(slope_middle) <= enough) return middle;
    if (slope_middle < 0) {
      lo = middle;
      slope_lo = slope_middle;
      slope_hi *= 0.5;
    } else {
      hi = middle;
      slope_hi = slope_middle;
      slope_lo *= 0.5;
    }
  }
  return lo > 0 ? lo : hi;
}

}  // namespace aprsim::physics
