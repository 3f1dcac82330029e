#include "world/physics/simplification/virtual_joints.hpp"

#include <algorithm>
#include <tuple>

namespace aprsim::physics {
namespace {

constexpr double kJointCfm = 1e-8;  // [m/(s N)]

bool before(const VirtualJoints::Pair& pair, const std::tuple<int, int>& key) {
  return std::tuple(pair.a, pair.b) < key;
}

Eigen::Isometry3d pose_of(const RigidBody& body) {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.linear() = body.R_WB();
  X_WB.translation() = body.p_W();
  return X_WB;
}

}  // namespace

VirtualJoints::VirtualJoints(const scene::Physics& physics, std::span<FreeBody> bodies)
    : step_s_(physics.step_s),
      speed_(physics.simplify_speed_m_s),
      accel_(physics.simplify_accel_m_s2),
      force_(physics.simplify_force_n),
      bodies_(bodies),
      v_before_(bodies.size(), Eigen::Vector3d::Zero()),
      group_(bodies.size(), -1) {}

/// The pairs are sorted.
bool VirtualJoints::joined(int a, int b) const {
  const std::tuple key(std::min(a, b), std::max(a, b));
  const auto at = std::lower_bound(pairs_.begin(), pairs_.end(), key, before);
  return at != pairs_.end() && std::tuple(at->a, at->b) == key;
}

void VirtualJoints::observe(std::span<const ContactConstraint> constraints) {
  // Deletion comes first. A pair that fails its test has contacts again for at least one step,
  // because joined pairs have none in this one.
  const std::uint64_t serial = next_serial_;
  const std::size_t count = pairs_.size();
  release_changed();
  const bool released = pairs_.size() != count;
  join_resting(constraints);
  if (released || next_serial_ != serial) find_groups();
  for (std::size_t i = 0; i < bodies_.size(); ++i) v_before_[i] = bodies_[i].v_com_W;
}

void VirtualJoints::remove_joints_of(int body) {
  const std::size_t count =
      std::erase_if(pairs_, [&](const Pair& pair) { return pair.a == body || pair.b == body; });
  if (count > 0) find_groups();
}

/// Algorithm 2: the joint is removed if |Fc - Fv| > e.
void VirtualJoints::release_changed() {
  std::erase_if(pairs_, [this](const Pair& pair) {
    return (pair.contact_force - pair.force_on_b()).norm() > force_;
  });
}

/// Algorithm 1: a pair with |v1 - v2| < e1 and |a1 - a2| < e2 gets a joint in place of its net
/// contact force Fc.
void VirtualJoints::join_resting(std::span<const ContactConstraint> constraints) {
  const int count = static_cast<int>(bodies_.size());
  const auto free = [count](int id) { return id >= 0 && id < count; };
  for (std::size_t i = 0; i < constraints.size();) {
    const int a = constraints[i].contact.a, b = constraints[i].contact.b;
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  // net, on a
    // The points of one pair follow each other in the list.
    for (; i < constraints.size() && constraints[i].contact.a == a && constraints[i].contact.b == b;
         ++i) {
      force += constraints[i].f_W;
    }
    if (!free(a) || !free(b)) continue;
    const auto ia = static_cast<std::size_t>(a), ib = static_cast<std::size_t>(b);
    const Eigen::Vector3d v = bodies_[ia].v_com_W - bodies_[ib].v_com_W;
    // The paper's |a1 - a2| by a backward difference of velocities.
    const Eigen::Vector3d accel = (v - (v_before_[ia] - v_before_[ib])) / step_s_;
    if (v.norm() >= speed_ || accel.norm() >= accel_) continue;
    if (a < b) {
      join(a, b, -force);
    } else {
      join(b, a, force);
    }
  }
}

void VirtualJoints::join(int a, int b, const Eigen::Vector3d& force_on_b) {
  // Fc of eq. 5 is noted as the joint's first force.
  Pair pair;
  pair.a = a;
  pair.b = b;
  pair.serial = next_serial_++;
  pair.contact_force = force_on_b;
  for (std::size_t i = 0; i < 3; ++i) {
    // Eq. 5: when the joint is made, its force equals the net contact force.
    pair.forces[i].guess_n.last = -force_on_b[static_cast<Eigen::Index>(i)];
  }
  pair.X_WA = pose_of(rigid_body(a));
  pair.X_WB = pose_of(rigid_body(b));
  pairs_.insert(std::lower_bound(pairs_.begin(), pairs_.end(), std::tuple(a, b), before), pair);
}

void VirtualJoints::add_to(Engine& engine, std::size_t number) {
  Pair& pair = pairs_[number];
  RigidBody &a = rigid_body(pair.a), &b = rigid_body(pair.b);
  engine.add_joint(FixedJoint{.a = a,
                              .b = b,
                              .X_WA = pair.X_WA,
                              .X_WB = pair.X_WB,
                              .lever_W = b.p_W() - a.p_W(),
                              .compliance = kJointCfm,
                              .forces = pair.forces});
}

void VirtualJoints::restore(const State& state) {
  pairs_ = state.pairs;
  v_before_ = state.v_before;
  group_ = state.group;
  next_serial_ = state.next_serial;
}

/// Connected components of the pairs, each labelled by its lowest body.
void VirtualJoints::find_groups() {
  std::fill(group_.begin(), group_.end(), -1);
  bool changed = true;
  while (changed) {  // labels sink to the lowest body of each group
    changed = false;
    for (const auto& pair : pairs_) {
      auto& a = group_[static_cast<std::size_t>(pair.a)];
      auto& b = group_[static_cast<std::size_t>(pair.b)];
      const auto label = [](int group, int body) { return group < 0 ? body : group; };
      const int lowest = std::min(label(a, pair.a), label(b, pair.b));
      changed = changed || a != lowest || b != lowest;
      a = b = lowest;
    }
  }
}

}  // namespace aprsim::physics
