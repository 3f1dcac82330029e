#include "world/physics/simplification/simplification.hpp"

#include <algorithm>

namespace aprsim::physics {
namespace {

constexpr std::size_t kFrozenCapacity = 1024;  // contacts to reserve for

}  // namespace

Simplification::Simplification(const scene::Physics& physics, std::span<FreeBody> bodies,
                               const StaticShapes& fixed)
    : merges_(physics.simplification == scene::Simplification::kMerge ||
              physics.simplification == scene::Simplification::kDormant),
      sleeps_(physics.simplification == scene::Simplification::kDormant),
      step_s_(physics.step_s),
      gravity_W_(0, 0, -physics.gravity_m_s2),
      bodies_(bodies),
      fixed_(&fixed),
      composites_(bodies, gravity_W_),
      sleeping_(bodies, fixed, composites_),
      rest_(physics, bodies),
      neighbours_(bodies.size()),
      islands_(bodies.size()) {
  if (physics.simplification == scene::Simplification::kVirtualJoints) {
    virtual_joints_.emplace(physics, bodies);
  }
  awake_.reserve(bodies.size());
  awake_roots_.reserve(bodies.size());
  scratch_.reserve(bodies.size());
  merged_.reserve(kFrozenCapacity);
  asleep_.reserve(kFrozenCapacity);
  list_awake();
}

void Simplification::list_awake() {
  awake_.clear();
  awake_roots_.clear();
  // Ascending order: every later loop over bodies is deterministic.
  for (int i = 0; i < static_cast<int>(bodies_.size()); ++i) {
    if (dormant(i) || body(i).lost_step || body(i).mounted) continue;
    awake_.push_back(i);
    if (root(i) == i) awake_roots_.push_back(i);
  }
}

// ---- readings

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
  if (dormant(i)) return sleeping_.lowest(i);
  if (composites_.is_merged(root(i))) return root(i);
  return virtual_joints_ ? virtual_joints_->group(i) : -1;
}

bool Simplification::resting(int i) const {
  return dormant(i) || (rest_.resting(i) && !body(i).lost_step);
}

BodyGrouping Simplification::grouping(int i) const {
  return {.carrier = composites_.parent(i),
          .sleeping = dormant(i) ? sleeping_.lowest(i) : -1,
          .joined = virtual_joints_ ? virtual_joints_->group(i) : -1};
}

std::uint64_t Simplification::changes() const {
  return changes_ + (virtual_joints_ ? virtual_joints_->changes() : 0);
}

int Simplification::joint_count() const {
  return static_cast<int>(joined_pairs().size()) + composites_.child_count() +
         sleeping_.root_count();
}

Eigen::Isometry3d Simplification::X_WB(int i) const {
  return dormant(i) ? sleeping_.X_WB(i) : body(i).X_WB;
}

Eigen::Vector3d Simplification::velocity(int i) const {
  return dormant(i) ? sleeping_.velocity(i) : body(i).v_com_W;
}

// ---- waking and unmerging

void Simplification::wake(int group) {
  const Eigen::Vector3d v = sleeping_.velocity(sleeping_.first(group));
  for (int i = sleeping_.first(group); i >= 0; i = sleeping_.next(i)) {
    // The belt's velocity of the last step, not of the coming one: the change is an impulse to be
    // solved.
    rest_.wake(i, v);
    at(i).support = -1;
    at(i).touched = at(i).near = false;
  }
  sleeping_.wake(group);
  asleep_.remove(group);
  ++changes_;
  list_awake();
}

void Simplification::touched_by_robot(int i) {
  at(i).touched = true;
  unmerge(i);
}

void Simplification::disturb(int i) {
  at(i).near = true;
  unmerge(i);
}

void Simplification::unmerge(int i) {
  if (composites_.parent(i) < 0) return;
  composites_.detach(i);
  merged_.remove(i);
  ++changes_;
  // A freed body must be at rest for the full time again before it merges; otherwise it would
  // alternate.
  rest_.restart_on_body(i);
  awake_roots_.insert(std::lower_bound(awake_roots_.begin(), awake_roots_.end(), i), i);
}

/// Bodies that rest on it are unmerged, too.
void Simplification::remove_lost(int i) {
  ++changes_;
  for (int m = composites_.root(i); m >= 0;) {
    const int after = composites_.next(m);
    if (composites_.parent(m) == i) {
      unmerge(m);
      m = composites_.root(i);  // its list has changed
    } else {
      m = after;
    }
  }
  unmerge(i);
  if (virtual_joints_) virtual_joints_->remove_joints_of(i);
  list_awake();
}

void Simplification::remove_mounted(int i) {
  if (dormant(i)) wake(sleeping_.group(i));
  remove_lost(i);
}

void Simplification::add(int i) {
  rest_.wake(i, body(i).v_com_W);
  rest_.restart_on_carrier(i);
  at(i) = {};
  list_awake();
}

void Simplification::set_step_s(double step_s) {
  step_s_ = step_s;
  rest_.set_step_s(step_s);
  if (virtual_joints_) virtual_joints_->set_step_s(step_s);
}

/// Waking bodies start with the belt's speed of the last step.
void Simplification::begin_step(double belt_speed_m_s) {
  for (const int i : awake_) at(i).touched = at(i).near = false;
  scratch_.clear();
  sleeping_.groups_to_wake(belt_speed_m_s, step_s_, scratch_);
  for (const int group : scratch_) wake(group);
  belt_speed_before_ = sleeping_.belt_speed_m_s();
  sleeping_.begin_step(belt_speed_m_s);
}

/// Newton and Euler for every member of every awake composite, against the cone of its contact.
void Simplification::find_overstressed(std::vector<int>& overstressed) {
  for (const int i : awake_roots_) {
    if (composites_.next(i) < 0) continue;
    // The composite's acceleration over the step: from the step's start to what was solved.
    const FreeBody& lead = body(i);
    RigidMotion motion;
    motion.origin_W = lead.origin_W();
    motion.omega_W = lead.body.omega_W();
    motion.accel_W = (lead.body.v_W() - lead.velocity_at(motion.origin_W)) / step_s_;
    motion.alpha_W = (motion.omega_W - lead.omega_W) / step_s_;
    for (int m = composites_.next(i); m >= 0; m = composites_.next(m)) {
      // Eq. 4 of IMECE2019-11345: the wrench that the contact must transmit follows from the
      // motion. Here it is tested before it acts, so that the release is in the same step.
      const Wrench wrench = composites_.required_wrench(m, motion);
      if (!composites_.cone(m).contains(wrench)) overstressed.push_back(m);
    }
  }
}

// ---- after a step

bool Simplification::is_free(int id) const {
  return id >= 0 && id < static_cast<int>(bodies_.size());
}

void Simplification::observe(std::span<const ContactConstraint> constraints,
                             std::span<const int> island_of) {
  // Order: contacts frozen in the last step are settled first; those of this step follow below.
  sleeping_.end_step(step_s_);
  merged_.settle();
  asleep_.settle();
  if (virtual_joints_) virtual_joints_->observe(constraints);
  update_islands(constraints, island_of);
  if (merges_) {
    find_supports(constraints);
    update_pairs(constraints, island_of);
  }
  if (sleeps_) fall_asleep(constraints, island_of);
  for (const int i : awake_) rest_.end_step(i);
}

/// Finds the only body that each composite touches. A change of it, or a second one, restarts the
/// count of rest.
void Simplification::find_supports(std::span<const ContactConstraint> constraints) {
  scratch_.clear();  // supports of the last step
  for (const int i : awake_roots_) {
    at(i).many_supports = false;
    scratch_.push_back(at(i).support);
    at(i).support = -1;
  }
  for (const auto& constraint : constraints) {
    add_support(constraint.contact.a, constraint.contact.b);
    add_support(constraint.contact.b, constraint.contact.a);
  }
  for (std::size_t k = 0; k < awake_roots_.size(); ++k) {
    const int i = awake_roots_[k];
    // Merging requires one support over the whole time, not one at a time.
    if (at(i).support != scratch_[k] || at(i).many_supports) rest_.restart_on_body(i);
  }
}

void Simplification::add_support(int a, int b) {
  if (!is_free(a)) return;
  Neighbours& of_root = at(root(a));
  if (!is_free(b) || root(a) != a || (of_root.support >= 0 && of_root.support != b)) {
    of_root.many_supports = true;
  } else {
    of_root.support = b;
  }
}

/// Finds the islands that have been at rest on their carriers for long enough.
void Simplification::update_islands(std::span<const ContactConstraint> constraints,
                                    std::span<const int> island_of) {
  // Carrier of each island, and its extent along the belt.
  for (const int i : awake_roots_) islands_[static_cast<std::size_t>(i)] = {};
  // Without sleep the carrier only matters on the belt.
  if (!sleeps_ && fixed_->belt < 0) constraints = {};
  for (const auto& constraint : constraints) {
    if (constraint.fixed < 0 || !is_free(constraint.contact.a)) continue;
    const int number = island_of[static_cast<std::size_t>(root(constraint.contact.a))];
    if (number < 0) continue;
    Island& island = islands_[static_cast<std::size_t>(number)];
    if (!constraint.belt) {
      island.on_fixed = true;
      continue;
    }
    const double x = (fixed_->X_CW * constraint.contact.p_W).x();
    island.on_belt = true;
    island.belt_min = std::min(island.belt_min, x);
    island.belt_max = std::max(island.belt_max, x);
  }
  // An island is quiet when all its bodies are.
  for (const int i : awake_) {
    const int number = island_of[static_cast<std::size_t>(root(i))];
    if (number < 0) {
      rest_.restart_on_carrier(i);
      continue;
    }
    Island& island = islands_[static_cast<std::size_t>(number)];
    if (root(i) == i) ++island.roots;
    count_on_carrier(i, island);
    if (!rest_.may_sleep(i) || at(i).near) island.quiet = false;
  }
}

/// Counts rest relative to the belt or to fixed things, also while the belt's speed changes.
void Simplification::count_on_carrier(int i, const Island& island) {
  const Eigen::Vector3d axis = island.on_belt ? fixed_->belt_axis_W : Eigen::Vector3d::Zero();
  const RestDetector::CarrierMotion carrier{.v_W = sleeping_.belt_speed_m_s() * axis,
                                            .v_before_W = belt_speed_before_ * axis,
                                            .travel_W = sleeping_.belt_travel_m() * axis};
  rest_.count_on_carrier(i, carrier, at(i).touched);
}

/// A composite at rest for some time relative to the only body that it touches is merged with it if
/// the wrench that this requires lies in the cone of their contact: while sliding it does not.
void Simplification::update_pairs(std::span<const ContactConstraint> constraints,
                                  std::span<const int> island_of) {
  scratch_.clear();
  for (const int i : awake_roots_) {
    const int support = at(i).support;
    if (support < 0 || at(i).many_supports) continue;
    const bool held = island_of[static_cast<std::size_t>(i)] < 0;
    // The child of two lone bodies is the one with the higher number, a gear.
    const bool mutual = at(support).support == i && !at(support).many_supports && support > i;
    if (held || mutual || at(i).touched || at(i).near) {
      rest_.restart_on_body(i);
    } else if (rest_.count_on_body(i, support)) {
      scratch_.push_back(i);
    }
  }
  for (const int i : scratch_) merge(i, at(i).support, constraints, island_of);
}

void Simplification::merge(int child, int support, std::span<const ContactConstraint> constraints,
                           std::span<const int> island_of) {
  // An earlier merger of this step may have made the child a member, or the support one of its own.
  if (root(child) != child || root(support) == child) return;
  const FreeBody& lower = body(support);
  RigidMotion motion;
  motion.origin_W = lower.com_W();
  // The test uses the acceleration that the step has had; a later change is tested by
  // find_overstressed().
  motion.accel_W = rest_.accel_W(support);
  motion.alpha_W = rest_.alpha_W(support);
  motion.omega_W = lower.omega_W;
  const ContactWrenchCone cone = cone_of(child, support, constraints);
  if (!cone.contains(composites_.required_wrench(child, motion))) return;
  composites_.attach(child, support, cone);
  ++changes_;
  for (const auto& constraint : constraints) {
    const auto& contact = constraint.contact;
    const bool on_a = contact.a == child && contact.b == support;
    if (!on_a && !(contact.b == child && contact.a == support)) continue;
    merged_.add(child, constraint, body(contact.a).X_WB, position_at_end(contact));
  }
  rest_.restart_on_body(child);
  const auto number = static_cast<std::size_t>(island_of[static_cast<std::size_t>(child)]);
  islands_[number].quiet = false;
  awake_roots_.erase(std::lower_bound(awake_roots_.begin(), awake_roots_.end(), child));
}

Eigen::Vector3d Simplification::position_at_end(const Contact& contact) const {
  return contact.p_W + step_s_ * body(contact.a).velocity_at(contact.p_W);
}

/// Friction cone of a composite's contact with its support, or with the belt for kGround. The
/// points were detected at the start of the step.
ContactWrenchCone Simplification::cone_of(int child, int support,
                                          std::span<const ContactConstraint> constraints) const {
  const FreeBody& upper = body(child);
  const Eigen::Isometry3d X_BW = upper.X_WB.inverse();
  ContactWrenchCone cone;
  for (const auto& constraint : constraints) {
    const auto& contact = constraint.contact;
    const bool on_a = contact.a == child && contact.b == support;
    if (!on_a && !(contact.b == child && contact.a == support)) continue;
    // Contact points are those of the step's start; both bodies have moved since, and at rest to
    // each other by the same amount.
    const Eigen::Vector3d p = contact.p_W + step_s_ * upper.velocity_at(contact.p_W);
    const Eigen::Vector3d n = X_BW.linear() * contact.n_W;
    cone.add(X_BW * p, on_a ? n : -n, constraint.friction);
  }
  cone.finish();
  return cone;
}

/// Quiet islands on one carrier become sleeping groups.
void Simplification::fall_asleep(std::span<const ContactConstraint> constraints,
                                 std::span<const int> island_of) {
  bool any = false;  // fell asleep
  for (const int number : awake_roots_) {
    const Island& island = islands_[static_cast<std::size_t>(number)];
    if (island.roots == 0 || !island.quiet || !(island.on_belt || island.on_fixed)) continue;
    // A group on both the belt and fixed things is only at rest while the belt is stopped.
    if (island.on_belt && island.on_fixed && sleeping_.belt_speed_m_s() != 0) continue;
    scratch_.clear();
    int lone = -1;
    for (const int i : awake_) {
      if (island_of[static_cast<std::size_t>(root(i))] != number) continue;
      scratch_.push_back(i);
      if (root(i) == i) lone = i;
    }
    Carrier carrier;
    // The interval of supporting points bounds how far the group may ride before it leaves the
    // belt.
    carrier.belt = island.on_belt;
    carrier.belt_min = island.belt_min;
    carrier.belt_max = island.belt_max;
    ContactWrenchCone cone;
    if (island.on_belt && !island.on_fixed && island.roots == 1) {
      cone = cone_of(lone, kGround, constraints);
      carrier.cone = &cone;
    }
    const int group = sleeping_.sleep(scratch_, carrier);
    for (const auto& constraint : constraints) {
      const auto& contact = constraint.contact;
      if (!is_free(contact.a) || island_of[static_cast<std::size_t>(root(contact.a))] != number) {
        continue;
      }
      asleep_.add(group, constraint, body(contact.a).X_WB, position_at_end(contact));
    }
    any = true;
  }
  if (!any) return;
  ++changes_;
  // Bodies leave the list only now: the loop above runs over it.
  list_awake();
}

// ---- keeping a state

Simplification::State Simplification::save() const {
  State state{composites_, sleeping_, std::nullopt, rest_.save(),
              merged_,     asleep_,   neighbours_,  belt_speed_before_};
  if (virtual_joints_) state.virtual_joints = virtual_joints_->save();
  return state;
}

void Simplification::restore(const State& state) {
  composites_.restore(state.composites);
  sleeping_.restore(state.sleeping);
  if (virtual_joints_ && state.virtual_joints) virtual_joints_->restore(*state.virtual_joints);
  rest_.restore(state.rest);
  merged_ = state.merged_contacts;
  asleep_ = state.sleeping_contacts;
  neighbours_ = state.neighbours;
  belt_speed_before_ = state.belt_speed_before;
  list_awake();
}

}  // namespace aprsim::physics
