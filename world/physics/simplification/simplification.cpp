#include "world/physics/simplification/simplification.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics {
namespace {

constexpr int kMergeSteps = 20;  // at rest relative to each other before two are merged
constexpr int kRestSteps = 20;   // at rest on the carrier before it counts
constexpr int kSleepSteps = 40;  // before a group falls asleep
constexpr double kShare = 0.1;   // of e1 and e2: stricter than the paper's criteria
constexpr double kDrift = 2e-7;  // [m] over all of that time: slow sliding is no rest

}  // namespace

Simplification::Simplification(const scene::Physics& physics, std::span<FreeBody> bodies,
                               const StaticShapes& fixed, dWorldID world)
    : merges_(physics.simplification == scene::Simplification::kMerge ||
              physics.simplification == scene::Simplification::kDormant),
      sleeps_(physics.simplification == scene::Simplification::kDormant),
      speed_(kShare * physics.simplify_speed_m_s),
      accel_(kShare * physics.simplify_accel_m_s2),
      step_s_(physics.step_s),
      gravity_W_(0, 0, -physics.gravity_m_s2),
      bodies_(bodies),
      fixed_(&fixed),
      composites_(bodies, gravity_W_),
      dormancy_(bodies, fixed, composites_),
      rest_(bodies.size()),
      islands_(bodies.size()) {
  if (physics.simplification == scene::Simplification::kVirtualJoints) {
    virtual_joints_.emplace(physics, bodies, world);
  }
  awake_.reserve(bodies.size());
  solids_.reserve(bodies.size());
  scratch_.reserve(bodies.size());
  list_awake();
}

void Simplification::list_awake() {
  awake_.clear();
  solids_.clear();
  for (int i = 0; i < static_cast<int>(bodies_.size()); ++i) {
    if (dormant(i)) continue;
    awake_.push_back(i);
    if (root(i) == i) solids_.push_back(i);
  }
}

// ---- what observers see

std::span<const VirtualJoints::Pair> Simplification::joined_pairs() const {
  if (!virtual_joints_) return {};
  return virtual_joints_->pairs();
}

api::GroupKind Simplification::group_kind(int i) const {
  if (dormant(i)) return api::GroupKind::kDormant;
  if (composites_.is_merged(root(i))) return api::GroupKind::kMerged;
  return group(i) >= 0 ? api::GroupKind::kJoined : api::GroupKind::kNone;
}

int Simplification::group(int i) const {
  if (dormant(i)) return dormancy_.lowest(i);
  if (composites_.is_merged(root(i))) return root(i);
  return virtual_joints_ ? virtual_joints_->group(i) : -1;
}

bool Simplification::resting(int i) const { return dormant(i) || at(i).quiet_steps >= kRestSteps; }

int Simplification::joint_count() const {
  return static_cast<int>(joined_pairs().size()) + composites_.child_count() +
         dormancy_.root_count();
}

Eigen::Isometry3d Simplification::X_WB(int i) const {
  return dormant(i) ? dormancy_.X_WB(i) : body(i).X_WB;
}

Eigen::Vector3d Simplification::velocity(int i) const {
  return dormant(i) ? dormancy_.velocity(i) : body(i).v_com_W;
}

// ---- waking and releasing

void Simplification::wake(int group) {
  const Eigen::Vector3d v = dormancy_.velocity(dormancy_.first(group));
  for (int i = dormancy_.first(group); i >= 0; i = dormancy_.next(i)) {
    Rest& rest = at(i);
    rest.quiet_steps = kRestSteps;  // it was, and will be unless it moves
    rest.pair_steps = 0;
    rest.below = -1;
    rest.touched = rest.near = false;
    rest.v_before = v;
    rest.omega_before.setZero();
  }
  dormancy_.wake(group);
  list_awake();
}

void Simplification::touched_by_robot(int i) {
  at(i).touched = true;
  release(i);
}

void Simplification::disturb(int i) {
  at(i).near = true;
  release(i);
}

void Simplification::release(int i) {
  if (composites_.parent(i) < 0) return;
  composites_.detach(i);
  at(i).pair_steps = 0;
  solids_.insert(std::lower_bound(solids_.begin(), solids_.end(), i), i);
}

void Simplification::begin_step(double belt_speed_m_s) {
  for (const int i : awake_) at(i).touched = at(i).near = false;
  scratch_.clear();
  dormancy_.groups_to_wake(belt_speed_m_s, step_s_, scratch_);
  for (const int group : scratch_) wake(group);
  belt_speed_before_ = dormancy_.belt_speed_m_s();
  dormancy_.begin_step(belt_speed_m_s);
}

void Simplification::find_overloaded(std::vector<int>& overloaded) {
  for (const int i : solids_) {
    if (composites_.next(i) < 0) continue;
    const FreeBody& lead = body(i);
    RigidMotion motion;
    motion.origin_W = lead.origin_W();
    const Eigen::Vector3d v = ode::vector(dBodyGetLinearVel(lead.body.get()));
    motion.omega_W = ode::vector(dBodyGetAngularVel(lead.body.get()));
    motion.accel_W = (v - lead.velocity_at(motion.origin_W)) / step_s_;
    motion.alpha_W = (motion.omega_W - lead.omega_W) / step_s_;
    for (int m = composites_.next(i); m >= 0; m = composites_.next(m)) {
      const Wrench wrench = composites_.required(m, motion);
      if (composites_.support(m).contains(wrench)) continue;
      overloaded.push_back(m);
      at(m).pull_W = body(m).X_WB.linear() * wrench.force;
    }
  }
}

// ---- after a step

const FreeBody* Simplification::free(int node) const {
  const bool is_free = node >= 0 && node < static_cast<int>(bodies_.size());
  return is_free ? &bodies_[static_cast<std::size_t>(node)] : nullptr;
}

void Simplification::observe(std::span<const ContactConstraint> touches,
                             std::span<const int> island_of) {
  dormancy_.end_step(step_s_);
  if (virtual_joints_) virtual_joints_->observe(touches, step_s_);
  judge_islands(touches, island_of);
  if (merges_) {
    note_touches(touches);
    judge_pairs(touches, island_of);
  }
  if (sleeps_) fall_asleep(touches, island_of);
  for (const int i : awake_) {
    at(i).v_before = body(i).v_com_W;
    at(i).omega_before = body(i).omega_W;
  }
}

void Simplification::note_touches(std::span<const ContactConstraint> touches) {
  scratch_.clear();
  for (const int i : solids_) {
    at(i).crowded = false;
    scratch_.push_back(at(i).below);
    at(i).below = -1;
  }
  for (const auto& touch : touches) {
    note_below(touch.contact.a, touch.contact.b);
    note_below(touch.contact.b, touch.contact.a);
  }
  for (std::size_t k = 0; k < solids_.size(); ++k) {
    Rest& rest = at(solids_[k]);
    if (rest.below != scratch_[k] || rest.crowded) rest.pair_steps = 0;
  }
}

void Simplification::note_below(int a, int b) {
  if (!free(a)) return;
  Rest& rest = at(root(a));
  if (!free(b) || root(a) != a || (rest.below >= 0 && rest.below != b)) {
    rest.crowded = true;
  } else {
    rest.below = b;
  }
}

void Simplification::judge_islands(std::span<const ContactConstraint> touches,
                                   std::span<const int> island_of) {
  for (const int i : solids_) islands_[static_cast<std::size_t>(i)] = {};
  for (const auto& touch : touches) {
    if (!free(touch.contact.a)) continue;
    const int number = island_of[static_cast<std::size_t>(root(touch.contact.a))];
    if (number < 0) continue;
    Island& island = islands_[static_cast<std::size_t>(number)];
    ++island.contacts;
    if (touch.fixed < 0) continue;
    if (!touch.belt) {
      island.on_fixed = true;
      continue;
    }
    const double x = (fixed_->X_CW * touch.contact.p_W).x();
    island.on_belt = true;
    island.belt_min = std::min(island.belt_min, x);
    island.belt_max = std::max(island.belt_max, x);
  }
  for (const int i : awake_) {
    const int number = island_of[static_cast<std::size_t>(root(i))];
    Rest& rest = at(i);
    if (number < 0) {
      rest.quiet_steps = 0;
      continue;
    }
    Island& island = islands_[static_cast<std::size_t>(number)];
    if (root(i) == i) ++island.solids;
    rest.quiet_steps = is_quiet(i, island) && !rest.touched ? rest.quiet_steps + 1 : 0;
    if (rest.quiet_steps < kSleepSteps || rest.near) island.quiet = false;
  }
}

/// At rest relative to the belt or to fixed things, through changes of the belt's speed too.
bool Simplification::is_quiet(int i, const Island& island) {
  Rest& rest = at(i);
  const FreeBody& free = body(i);
  const Eigen::Vector3d axis = island.on_belt ? fixed_->belt_axis_W : Eigen::Vector3d::Zero();
  const Eigen::Vector3d v = free.v_com_W - dormancy_.belt_speed_m_s() * axis;
  const Eigen::Vector3d v_before = rest.v_before - belt_speed_before_ * axis;
  Eigen::Isometry3d now = free.X_WB;
  now.translation() -= dormancy_.belt_travel_m() * axis;
  if (rest.quiet_steps == 0) rest.quiet_at = now;
  const double drift = (now.translation() - rest.quiet_at.translation()).norm() +
                       (now.linear() - rest.quiet_at.linear()).norm() * free.radius_m;
  // Crawling starts the count anew, but is rest enough for those who look.
  if (drift > kDrift && rest.quiet_steps > kRestSteps) {
    rest.quiet_steps = kRestSteps;
    rest.quiet_at = now;
  }
  return v.norm() < speed_ && free.omega_W.norm() * free.radius_m < speed_ &&
         (v - v_before).norm() < accel_ * step_s_;
}

/// A solid at rest for some time relative to the only body that it touches is merged with it when
/// their contact can bear it: while sliding it can not.
void Simplification::judge_pairs(std::span<const ContactConstraint> touches,
                                 std::span<const int> island_of) {
  scratch_.clear();
  for (const int i : solids_) {
    Rest& rest = at(i);
    if (rest.below < 0 || rest.crowded) continue;
    const Rest& under = at(rest.below);
    const bool held = island_of[static_cast<std::size_t>(i)] < 0;
    const bool mutual = under.below == i && !under.crowded && rest.below > i;
    if (held || mutual || rest.touched || rest.near || !rests_on(i, rest.below)) {
      rest.pair_steps = 0;
      continue;
    }
    if (++rest.pair_steps >= kMergeSteps) scratch_.push_back(i);
  }
  for (const int i : scratch_) {
    const int below = at(i).below;
    if (root(i) != i || root(below) == i) continue;
    const FreeBody& lower = body(below);
    RigidMotion motion;
    motion.origin_W = lower.com_W();
    motion.accel_W = (lower.v_com_W - at(below).v_before) / step_s_;
    motion.alpha_W = (lower.omega_W - at(below).omega_before) / step_s_;
    motion.omega_W = lower.omega_W;
    const ContactWrenchCone support = support_of(i, below, touches);
    if (!support.contains(composites_.required(i, motion))) continue;
    composites_.attach(i, below, support);
    at(i).pair_steps = 0;
    at(i).pull_W.setZero();
    islands_[static_cast<std::size_t>(island_of[static_cast<std::size_t>(i)])].quiet = false;
    solids_.erase(std::lower_bound(solids_.begin(), solids_.end(), i));
  }
}

bool Simplification::rests_on(int child, int below) {
  Rest& rest = at(child);
  const FreeBody& upper = body(child);
  const FreeBody& lower = body(below);
  const Eigen::Vector3d lever = upper.com_W() - lower.com_W();
  const Eigen::Vector3d v = upper.v_com_W - lower.v_com_W - lower.omega_W.cross(lever);
  const Eigen::Vector3d v_before =
      rest.v_before - at(below).v_before - at(below).omega_before.cross(lever);
  const Eigen::Vector3d spin = upper.omega_W - lower.omega_W;
  const bool slow = v.norm() < speed_ && spin.norm() * upper.radius_m < speed_ &&
                    (v - v_before).norm() < accel_ * step_s_;
  if (!slow) return false;
  const Eigen::Isometry3d X = lower.X_WB.inverse() * upper.X_WB;
  if (rest.pair_steps == 0) rest.pair_at = X;
  return (X.translation() - rest.pair_at.translation()).norm() +
             (X.linear() - rest.pair_at.linear()).norm() * upper.radius_m <
         kDrift;
}

/// The contact of a solid with the body or, for below = -1, the belt under it. The points were
/// found before the step moved everything.
ContactWrenchCone Simplification::support_of(int child, int below,
                                             std::span<const ContactConstraint> touches) const {
  const FreeBody& upper = body(child);
  const Eigen::Isometry3d X_BW = upper.X_WB.inverse();
  ContactWrenchCone support;
  for (const auto& touch : touches) {
    const auto& contact = touch.contact;
    const bool on_a = contact.a == child && contact.b == below;
    if (!on_a && !(contact.b == child && contact.a == below)) continue;
    const Eigen::Vector3d p = contact.p_W + step_s_ * upper.velocity_at(contact.p_W);
    const Eigen::Vector3d n = X_BW.linear() * contact.n_W;
    support.add(X_BW * p, on_a ? n : -n, touch.friction);
  }
  support.finish();
  return support;
}

void Simplification::fall_asleep(std::span<const ContactConstraint> touches,
                                 std::span<const int> island_of) {
  bool any = false;
  for (const int number : solids_) {
    const Island& island = islands_[static_cast<std::size_t>(number)];
    if (island.solids == 0 || !island.quiet || !(island.on_belt || island.on_fixed)) continue;
    if (island.on_belt && island.on_fixed && dormancy_.belt_speed_m_s() != 0) continue;
    scratch_.clear();
    int lone = -1;
    for (const int i : awake_) {
      if (island_of[static_cast<std::size_t>(root(i))] != number) continue;
      scratch_.push_back(i);
      if (root(i) == i) lone = i;
    }
    Carrier carrier;
    carrier.belt = island.on_belt;
    carrier.contacts = island.contacts;
    carrier.belt_min = island.belt_min;
    carrier.belt_max = island.belt_max;
    ContactWrenchCone support;
    if (island.on_belt && !island.on_fixed && island.solids == 1) {
      support = support_of(lone, kGround, touches);
      carrier.support = &support;
    }
    dormancy_.sleep(scratch_, carrier);
    any = true;
  }
  if (!any) return;
  // Bodies leave the list only now: the loop above runs over it.
  list_awake();
}

// ---- keeping a state

Simplification::State Simplification::save() const {
  State state{composites_, dormancy_, std::nullopt, rest_, belt_speed_before_};
  if (virtual_joints_) state.virtual_joints = virtual_joints_->save();
  return state;
}

void Simplification::restore(const State& state) {
  composites_.restore(state.composites);
  dormancy_.restore(state.dormancy);
  if (virtual_joints_ && state.virtual_joints) virtual_joints_->restore(*state.virtual_joints);
  rest_ = state.rest;
  belt_speed_before_ = state.belt_speed_before;
  list_awake();
}

}  // namespace aprsim::physics
