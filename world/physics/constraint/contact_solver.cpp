#include "world/physics/constraint/contact_solver.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "world/base/simd/vector_clones.hpp"

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

/// Of contacts whose gain is S about one centre, on that body and another: blocks S, -S T, -T' S
/// and T' S T, where T = (1, -[d]; 0, 1) takes moments from that centre to the other one by d.
inline void add_shifted(const SixColumns& S, const Vector3& d, BlockLu::Block& forward,
                        BlockLu::Block& backward, BlockLu::Block& other) {
  // With d x the upper half added to the lower one.
  const auto moved = [&d](const Six& column) {
    Six out = column;
    out.head[3] += d.y() * column[2] - d.z() * column[1];
    out.tail +=
        Six::Pair{d.z() * column[0] - d.x() * column[2], d.x() * column[1] - d.y() * column[0]};
    return out;
  };
  for (int j = 0; j < 6; ++j) {
    Six shifted = S.of[j];
    if (j >= 3) {
      const int u = (j - 2) % 3, v = (j - 1) % 3;  // the axes behind its own
      shifted = shifted + (d(u) * S.of[v] - d(v) * S.of[u]);
    }
    add_column(-1 * shifted, forward, j);
    add_column(-1 * moved(S.of[j]), backward, j);
    add_column(moved(shifted), other, j);
  }
}

/// Adds a b'.
inline void add_outer(const BlockLu::Vector6& a, const BlockLu::Vector6& b, BlockLu::Block& out) {
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) out(i, j) += a(i) * b(j);
  }
}

/// The residual that does after so many Newton steps.
double enough_m_s(const ContactSolver::Settings& settings, int iterations) {
  if (iterations <= kPatient) return settings.tolerance_m_s;
  const double grown = settings.tolerance_m_s * std::pow(10, (iterations - kPatient) / kTenfold);
  return std::max(settings.tolerance_m_s, std::min(settings.coarsest_m_s, grown));
}

}  // namespace

void ContactSolver::clear() {
  bodies_.clear();
  moving_.clear();
  rows_.clear();
  pack_count_ = 0;
  places_.clear();
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

/// Contacts of the same two bodies stand together.
int ContactSolver::add_contact(const ContactDescription& contact) {
  const bool joins = pack_count_ > 0 && packs().back().takes(contact);
  if (!joins) {
    if (packs_.size() == index(pack_count_)) packs_.emplace_back();
    ++pack_count_;
    packs().back().begin(contact.a, contact.b);
  }
  packs().back().add(contact);
  places_.emplace_back(pack_count_ - 1, packs().back().count - 1);
  return static_cast<int>(places_.size()) - 1;
}

Vector3 ContactSolver::contact_impulse_ns(int contact) const {
  const auto& [pack, lane] = places_[index(contact)];
  return packs_[index(pack)].impulse_W(lane);
}

Vector3 ContactSolver::contact_turn_nms(int contact) const {
  const auto& [pack, lane] = places_[index(contact)];
  return packs_[index(pack)].torque_W(lane);
}

// ---- the problem

/// Behind the last of the packs of the same two bodies.
inline std::size_t ContactSolver::end_of_pair(std::size_t first) const {
  const auto all = packs();
  std::size_t end = first + 1;
  while (end < all.size() && all[end].a == all[first].a && all[end].b == all[first].b) ++end;
  return end;
}

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
  for (ContactPack& pack : packs()) pack.place = pair_of(pack.a, pack.b);
  matrix_.analyse(static_cast<int>(moving_.size()), pairs_);
  gradient_.resize(moving_.size());
  direction_.resize(moving_.size());
  rows_kept_ = false;
}

inline void ContactSolver::push(int number, const Vector3& impulse, const Vector3& moment) {
  if (number != kFixed && at(number).moves()) at(number).push(impulse, moment);
}

inline void ContactSolver::push(const ContactPack& pack, const ContactPack::Net& net) {
  const auto upper = [](const Six& of) { return Vector3(of[0], of[1], of[2]); };
  const auto lower = [](const Six& of) { return Vector3(of[3], of[4], of[5]); };
  push(pack.a, upper(net.on_a), lower(net.on_a));
  push(pack.b, -upper(net.against_b), -lower(net.against_b));
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
  for (const ContactPack& pack : packs()) {
    if (!pack.idle()) push(pack, pack.net());
  }
}

/// y = J V - target, of every row and contact.
APRSIM_VECTOR_CLONES void ContactSolver::evaluate_velocities() {
  for (Row& row : rows_) row.y = velocity_of(row.a) + velocity_of(row.b) - row.target;
  for (ContactPack& pack : packs()) pack.evaluate_velocities(find(pack.a), find(pack.b));
}

/// Which contacts are of bodies that rows drive.
void ContactSolver::note_driven() {
  for (const Row& row : rows_) {
    for (const Side* side : {&row.a, &row.b}) {
      if (side->body != kFixed) at(side->body).driven = true;
    }
  }
  const auto is_driven = [this](int body) { return body != kFixed && at(body).driven; };
  for (ContactPack& pack : packs()) pack.loose = !is_driven(pack.a) && !is_driven(pack.b);
}

APRSIM_VECTOR_CLONES void ContactSolver::complete_contacts() {
  for (ContactPack& pack : packs()) pack.complete(find(pack.a), find(pack.b));
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
  for (const ContactPack& pack : packs()) {
    double& of = pack.loose ? loose : driven;
    of = std::max(of, pack.residual(kHardTangent, kSlidingShare, kLever));
  }
  return {.all_m_s = std::max({rows, driven, loose}),
          .excess_m_s = std::max({rows, driven, loose - slack_m_s_})};
}

void ContactSolver::swap_velocities() {
  for (const int i : moving_) at(i).twist = at(i).searched;
}

// ---- the outer iteration

/// The proximal term's share of each diagonal.
APRSIM_VECTOR_CLONES void ContactSolver::set_softness(double epsilon) {
  for (Row& row : rows_) row.D = row.softness + epsilon * row.W;
  for (ContactPack& pack : packs()) pack.set_softness(epsilon, kHardTangent);
}

/// Back to the centres, and to their velocities.
void ContactSolver::return_to_centres() {
  for (Row& row : rows_) row.now.x = row.now.centre;
  for (ContactPack& pack : packs()) {
    pack.x = pack.centre;
    pack.torque = pack.torque_centre;
  }
  velocities_from_impulses();
  evaluate_velocities();
}

/// The present impulses become the centres, the present slip the correction.
APRSIM_VECTOR_CLONES void ContactSolver::recentre() {
  for (Row& row : rows_) row.now.centre = row.now.x;
  for (ContactPack& pack : packs()) {
    pack.centre = pack.x;
    pack.torque_centre = pack.torque;
  }
  recentre_slip();
}

APRSIM_VECTOR_CLONES void ContactSolver::recentre_slip() {
  for (ContactPack& pack : packs()) pack.recentre_slip();
}

APRSIM_VECTOR_CLONES void ContactSolver::take_last() {
  for (Row& row : rows_) row.now.x = row.other_guess;
  for (ContactPack& pack : packs()) pack.set_impulse(pack.last_W, pack.last_turn_W);
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
  const auto all = packs();
  for (std::size_t first = 0, end = 0; first < all.size(); first = end) {
    end = end_of_pair(first);
    const auto pair = all.subspan(first, end - first);
    int bearing = 0;
    for (ContactPack& pack : pair) {
      pack.evaluate_contact_velocities(find(pack.a), find(pack.b));
      bearing += pack.bearing();
    }
    if (bearing == 0) continue;
    const double share = 1.0 / bearing;
    for (ContactPack& pack : pair) push(pack, pack.net_of(pack.relax(share)));
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
  complete_contacts();
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
    Gradient gradient = evaluate();
    while (inner < kMostInner && outcome.iterations < settings.most_iterations) {
      if (gradient.speed_m_s <= wanted && inner > 0) break;
      ++outcome.iterations;
      if (!find_direction()) {
        good = false;
        break;
      }
      ++inner;
      find_rates();
      if (exact_ && backtrack(gradient)) continue;
      if (exact_ && epsilon < kMostEpsilon) {
        good = false;
        break;
      }
      if (exact_) {
        exact_ = false;
        recentre_slip();
        gradient = evaluate();
        continue;
      }
      move_along(line_search());
      gradient = evaluate();
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
  best_contacts_.resize(packs().size());
  for (std::size_t i = 0; i < rows_.size(); ++i) best_rows_[i] = rows_[i].now.x;
  for (std::size_t i = 0; i < packs().size(); ++i) {
    best_contacts_[i] = {packs_[i].x, packs_[i].torque};
  }
}

void ContactSolver::take_best() {
  for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].now.x = best_rows_[i];
  for (std::size_t i = 0; i < packs().size(); ++i) {
    packs_[i].x = best_contacts_[i].x;
    packs_[i].torque = best_contacts_[i].torque;
  }
}

// ---- the convex problem

/// Impulses that belong to the velocities y + along * rate, and their derivatives.
APRSIM_VECTOR_CLONES void ContactSolver::evaluate_impulses(double along) {
  evaluate_rows(along);
  const Lanes share = spread(along);
  for (ContactPack& pack : packs()) {
    pack.evaluate_impulses(pack.y + share * pack.rate, pack.turn + share * pack.turn_rate, exact_,
                           kHardTangent);
  }
}

void ContactSolver::evaluate_rows(double along) {
  for (Row& row : rows_) {
    if (!(row.D > 0)) continue;
    const double y = row.y + along * row.rate;
    // D x = (D - softness) centre - y, then within bounds.
    const double z = ((row.D - row.softness) * row.now.centre - y) / row.D;
    row.now.x = std::clamp(z, row.lo, row.hi);
    row.now.gain = z > row.lo && z < row.hi ? 1 / row.D : 0;
  }
}

/// The impulses that belong to the velocities, and M (V - V_free) - J' x.
APRSIM_VECTOR_CLONES ContactSolver::Gradient ContactSolver::evaluate() {
  for (const int i : moving_) {
    const Body& body = at(i);
    const Vector3 p = body.kg * (body.twist.v - body.free.v);
    const Vector3 m = body.inertia * (body.twist.omega - body.free.omega);
    const Six g = {Lanes{p.x(), p.y(), p.z(), m.x()}, Six::Pair{m.y(), m.z()}};
    g.store(gradient_[index(body.unknown)].data());
  }
  const auto add = [this](int number, double sign, const Six& impulse) {
    if (number == kFixed || !at(number).moves()) return;
    double* g = gradient_[index(at(number).unknown)].data();
    (Six::load(g) + sign * impulse).store(g);
  };
  evaluate_rows(0);
  for (const Row& row : rows_) {
    for (const Side* side : {&row.a, &row.b}) {
      const Vector3 &v = side->linear, &w = side->angular;
      add(side->body, -row.now.x, {Lanes{v.x(), v.y(), v.z(), w.x()}, Six::Pair{w.y(), w.z()}});
    }
  }
  for (ContactPack& pack : packs()) {
    pack.evaluate_impulses(pack.y, pack.turn, exact_, kHardTangent);
    if (pack.idle()) continue;
    const ContactPack::Net net = pack.net();
    add(pack.a, -1, net.on_a);
    add(pack.b, 1, net.against_b);
  }
  Gradient out;
  double speed2 = 0;
  for (const int i : moving_) {
    const Body& body = at(i);
    const Vector6& g = gradient_[index(body.unknown)];
    const Vector3 dv = body.inverse_kg * g.head<3>(), dw = body.inverse_inertia * g.tail<3>();
    out.energy += g.head<3>().dot(dv) + g.tail<3>().dot(dw);
    speed2 = std::max({speed2, dv.squaredNorm(), kLever * kLever * dw.squaredNorm()});
  }
  out.speed_m_s = std::sqrt(speed2);
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
  const auto all = packs();
  for (std::size_t first = 0, end = 0; first < all.size(); first = end) {
    end = end_of_pair(first);
    const ContactPack& of = all[first];
    const int a = of.a == kFixed ? -1 : at(of.a).unknown,
              b = of.b == kFixed ? -1 : at(of.b).unknown;
    SixColumns sum = SixColumns::zero();
    bool any = false;
    for (const ContactPack& pack : all.subspan(first, end - first)) {
      if (!pack.yields()) continue;
      any = true;
      pack.add_gain(a >= 0, sum);
    }
    if (!any) continue;
    sum.add_to(matrix_.diagonal(a >= 0 ? a : b));
    if (of.place < 0) continue;
    // Of b: the same impulses, and moments about its own centre.
    const Vector3 shift = of.lever_b.at(0) - of.lever_a.at(0);
    const auto place = matrix_.place(index(of.place));
    add_shifted(sum, shift, matrix_.forward(place), matrix_.backward(place), matrix_.diagonal(b));
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
  for (const ContactPack& pack : packs()) sum -= pack.power();
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
  for (ContactPack& pack : packs()) pack.evaluate_rates(d_of(pack.a), d_of(pack.b));
}

APRSIM_VECTOR_CLONES void ContactSolver::move_along(double step) {
  for (const int i : moving_) {
    Body& body = at(i);
    const Vector6& d = direction_[index(body.unknown)];
    body.twist.v += step * d.head<3>();
    body.twist.omega += step * d.tail<3>();
  }
  for (Row& row : rows_) row.y += step * row.rate;
  for (ContactPack& pack : packs()) pack.move_along(step);
}

/// The longest of a few steps that brings the equations nearer to zero; false = none, and nothing
/// has changed.
bool ContactSolver::backtrack(Gradient& gradient) {
  double step = 1, moved = 0;
  for (int i = 0; i < kMostHalvings; ++i, step *= 0.5) {
    move_along(step - moved);
    moved = step;
    const Gradient next = evaluate();
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
