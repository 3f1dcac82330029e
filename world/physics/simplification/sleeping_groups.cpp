#include "world/physics/simplification/sleeping_groups.hpp"

#include <algorithm>

#include "world/physics/collision/speculative/speculative_contacts.hpp"

namespace aprsim::physics {
namespace {

constexpr double kBeltMargin = 2e-3;  // [m] from the belt's end
constexpr double kClearance = 1e-3;   // [m] at which a riding box counts as meeting an obstacle
constexpr double kSameAccel = 1e-9;   // [m/s2], as rounding makes of one
constexpr double kOnTop = 1e-4;       // [m] by which a group may sink into what carries it

}  // namespace

SleepingGroups::SleepingGroups(std::span<FreeBody> bodies, const StaticShapes& fixed,
                               const Composites& composites)
    : bodies_(bodies),
      fixed_(&fixed),
      composites_(&composites),
      belt_axis_W_(fixed.belt_axis_W),
      group_(bodies.size(), -1),
      next_(bodies.size(), -1),
      poses_(bodies.size()),
      groups_(bodies.size()) {
  active_.reserve(bodies.size());
  for (std::size_t i = bodies.size(); i > 0; --i) spare_.push_back(static_cast<int>(i) - 1);
}

Eigen::Vector3d SleepingGroups::shift(const Group& group) const {
  if (!group.belt) return Eigen::Vector3d::Zero();
  return (travel_ - group.travel) * fixed_->belt_axis_W;
}

/// Bodies that fell asleep on a stopped belt have bounds without a prediction horizon, which is
/// added here.
Aabb SleepingGroups::box(int g) const {
  const Group& group = at(g);
  // The box must contain the group over the look-ahead of those that search for contacts with it.
  const double ahead = kLookaheadSteps * body(group.lowest).step_s * velocity(group.lowest).norm();
  return group.box.moved(shift(group)).grown(ahead);
}

Eigen::Isometry3d SleepingGroups::X_WB(int i) const {
  Eigen::Isometry3d X = body(i).X_WB;
  X.translation() += shift(at(group(i)));
  return X;
}

/// Whether the belt can accelerate the group: the wrench that each member requires of what it rests
/// on lies in the cone of that contact, the root's in that of its contact with the belt.
bool SleepingGroups::contains(const Group& group, double belt_accel) const {
  if (!group.has_cone) return false;
  RigidMotion motion;
  // A group translates with the belt: no angular acceleration, and so one scalar describes its
  // motion.
  motion.accel_W = belt_accel * fixed_->belt_axis_W;
  for (int b = group.lowest; b >= 0; b = next(b)) {
    if (composites_->parent(b) >= 0) {
      if (!composites_->contains(b, motion)) return false;
    } else if (!group.cone.contains(composites_->required_wrench(b, motion))) {
      return false;
    }
  }
  return true;
}

void SleepingGroups::groups_to_wake(double belt_speed_m_s, double step_s,
                                    std::vector<int>& to_wake) {
  // Two conditions per group: the position at which it meets something, and the acceleration that
  // its contacts bear. Both are intervals, and the common intervals of all groups are tested first.
  const double accel = (belt_speed_m_s - speed_) / step_s;
  const double travel = travel_ + belt_speed_m_s * step_s;
  const bool calm = travel <= travel_high_ && travel >= travel_low_;
  const auto within = [accel](double low, double high) {
    return accel >= low - kSameAccel && accel <= high + kSameAccel;
  };
  // No group on the belt is affected.
  if (calm && within(accel_low_, accel_high_)) return;
  for (const int g : active_) {
    Group& group = at(g);
    if (!group.belt) continue;
    const bool runs_into = travel > group.travel_high || travel < group.travel_low;
    const bool known = within(group.accel_low, group.accel_high);
    if (runs_into || (!known && !contains(group, accel))) {
      to_wake.push_back(g);
      continue;
    }
    // The required wrench is linear in the acceleration and the cones are convex: all between two
    // bearable accelerations is bearable.
    group.accel_low = std::min(group.accel_low, accel);
    group.accel_high = std::max(group.accel_high, accel);
  }
  update_limits();
}

/// The intervals of travel and acceleration within which no group wakes.
void SleepingGroups::update_limits() {
  travel_low_ = accel_low_ = -1e30;
  travel_high_ = accel_high_ = 1e30;
  for (const int g : active_) {
    const Group& group = at(g);
    if (!group.belt) continue;
    travel_low_ = std::max(travel_low_, group.travel_low);
    travel_high_ = std::min(travel_high_, group.travel_high);
    accel_low_ = std::max(accel_low_, group.accel_low);
    accel_high_ = std::min(accel_high_, group.accel_high);
  }
}

// ---- obstacles

/// The belt's travel at which the group's box meets an obstacle that stays in place: moving box
/// against box, axis by axis (Ericson 2005, ch. 5.5.8).
void SleepingGroups::limit_travel_by(Group& group, const Aabb& obstacle,
                                     const Eigen::Vector3d& axis, double travel) {
  // Travel interval in which the boxes overlap, axis by axis.
  double enter = -1e30, leave = 1e30;
  for (int k = 0; k < 3; ++k) {
    const double low = obstacle.min[k] - group.box.max[k] - kClearance;
    const double high = obstacle.max[k] - group.box.min[k] + kClearance;
    const double a = axis[k];
    if (std::abs(a) < 1e-9) {
      if (low > 0 || high < 0) return;
      continue;
    }
    enter = std::max(enter, std::min(low / a, high / a));
    leave = std::min(leave, std::max(low / a, high / a));
  }
  if (enter > leave) return;
  // Ahead, behind, or around the box already.
  const double now = travel - group.travel;
  if (enter > now) {
    group.travel_high = std::min(group.travel_high, group.travel + enter);
  } else if (leave < now) {
    group.travel_low = std::max(group.travel_low, group.travel + leave);
  } else {
    group.travel_low = group.travel_high = travel;  // around the box: any motion may touch
  }
}

void SleepingGroups::limit_travel(Group& group, const Carrier& carrier) {
  const double half = 0.5 * fixed_->belt_length_m - kBeltMargin;
  group.travel_high = std::max(travel_, travel_ + half - carrier.belt_max);
  group.travel_low = std::min(travel_, travel_ - half - carrier.belt_min);
  for (std::size_t i = 0; i < fixed_->shapes.size(); ++i) {
    const StaticShape& shape = fixed_->shapes[i];
    // Shapes under the group do not stop it.
    if (shape.belt || shape.bounds.max.z() < group.box.min.z() + kOnTop) continue;
    limit_travel_by(group, shape.bounds, fixed_->belt_axis_W, travel_);
  }
  for (const int g : active_) {
    if (!at(g).belt) limit_travel_by(group, at(g).box, fixed_->belt_axis_W, travel_);
  }
}

// ---- falling asleep and waking

int SleepingGroups::sleep(std::span<const int> members, const Carrier& carrier) {
  // Slots are reused; their number is bounded by the number of bodies.
  const int slot = spare_.back();
  spare_.pop_back();
  Group& group = at(slot);
  group = Group{};
  group.lowest = members.front();
  group.belt = carrier.belt;
  group.travel = travel_;
  if (carrier.cone) {
    group.has_cone = true;
    group.cone = *carrier.cone;
  }
  const Eigen::Vector3d v =
      carrier.belt ? (speed_ * fixed_->belt_axis_W).eval() : Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < members.size(); ++k) {
    const auto b = static_cast<std::size_t>(members[k]);
    group_[b] = slot;
    next_[b] = k + 1 < members.size() ? members[k + 1] : -1;
    FreeBody& free = bodies_[b];
    free.v_com_W = v;
    free.omega_W.setZero();
    group.box = k == 0 ? free.bounds : group.box.joined(free.bounds);
    if (composites_->parent(members[k]) < 0) ++group.roots;
  }
  // A group at rest is in the way of those that ride the belt.
  if (carrier.belt) {
    limit_travel(group, carrier);
  } else {
    for (const int g : active_) {
      if (at(g).belt) limit_travel_by(at(g), group.box, fixed_->belt_axis_W, travel_);
    }
  }
  active_.insert(std::lower_bound(active_.begin(), active_.end(), slot), slot);
  roots_ += group.roots;
  record_poses(slot);
  update_limits();
  return slot;
}

void SleepingGroups::sync_poses(int g) {
  Group& group = at(g);
  const Eigen::Vector3d d = shift(group);
  const Eigen::Vector3d v = velocity(group.lowest);
  for (int b = group.lowest; b >= 0; b = next(b)) {
    FreeBody& free = body(b);
    free.v_com_W = v;
    free.X_WB.translation() += d;
    free.update_bounds();
    group.box = b == group.lowest ? free.bounds : group.box.joined(free.bounds);
  }
  group.travel = travel_;
  record_poses(g);
}

void SleepingGroups::record_poses(int g) {
  const Group& group = at(g);
  for (int b = group.lowest; b >= 0; b = next(b)) {
    const Eigen::Isometry3d& X_WB = body(b).X_WB;
    poses_[static_cast<std::size_t>(b)] = {X_WB.translation(), Eigen::Quaterniond(X_WB.linear()),
                                           group.travel, group.lowest, group.belt};
  }
}

void SleepingGroups::record_poses() {
  for (const int g : active_) record_poses(g);
}

void SleepingGroups::wake(int g) {
  sync_poses(g);
  Group& group = at(g);
  for (int b = group.lowest; b >= 0;) {
    const int after = next(b);
    group_[static_cast<std::size_t>(b)] = next_[static_cast<std::size_t>(b)] = -1;
    // Rigid bodies of roots were not updated during sleep. Members follow their root in the next
    // step.
    if (composites_->root(b) == b) {
      FreeBody& free = body(b);
      free.body.set_position(free.origin_W());
      free.body.set_velocity(free.v_com_W, free.omega_W);
    }
    b = after;
  }
  roots_ -= group.roots;
  active_.erase(std::lower_bound(active_.begin(), active_.end(), g));
  spare_.push_back(g);
  update_limits();
}

bool SleepingGroups::has_valid_list(int g, std::vector<char>& listed) const {
  const int count = static_cast<int>(group_.size());
  if (at(g).lowest < 0) return false;
  for (int b = at(g).lowest; b >= 0; b = next(b)) {
    if (b >= count || listed[static_cast<std::size_t>(b)] != 0 || group(b) != g) return false;
    if (next(b) >= 0 && next(b) <= b) return false;
    listed[static_cast<std::size_t>(b)] = 1;
  }
  return true;
}

bool SleepingGroups::is_consistent() const {
  const int count = static_cast<int>(groups_.size());
  std::vector<char> used(groups_.size(), 0), listed(group_.size(), 0);
  for (const std::vector<int>* slots : {&active_, &spare_}) {
    for (const int g : *slots) {
      if (g < 0 || g >= count || used[static_cast<std::size_t>(g)] != 0) return false;
      used[static_cast<std::size_t>(g)] = 1;
    }
  }
  int roots = 0;
  for (const int g : active_) {
    if (!has_valid_list(g, listed)) return false;
    roots += at(g).roots;
  }
  for (std::size_t b = 0; b < group_.size(); ++b) {
    if (listed[b] == 0 && (group_[b] != -1 || next_[b] != -1)) return false;
  }
  return roots == roots_ && std::ranges::is_sorted(active_) &&
         std::ranges::all_of(used, [](char is_used) { return is_used != 0; });
}

void SleepingGroups::restore(const SleepingGroups& from) {
  // The references stay those of this world.
  const auto bodies = bodies_;
  const auto* fixed = fixed_;
  const auto* composites = composites_;
  const Eigen::Vector3d axis = belt_axis_W_;
  *this = from;
  bodies_ = bodies;
  fixed_ = fixed;
  composites_ = composites;
  belt_axis_W_ = axis;
}

}  // namespace aprsim::physics
