#include "world/physics/simplification/virtual_joints.hpp"

#include <algorithm>
#include <tuple>

#include "world/physics/constraint/constraint_system.hpp"

namespace aprsim::physics {
namespace {

constexpr double kJointErp = 0.2, kJointCfm = 1e-8;

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

/// A fixed joint as six bilateral rows, translation at b's origin, then rotation.
void VirtualJoints::add_to(ConstraintSystem& system, std::size_t number) {
  Pair& pair = pairs_[number];
  using Eigen::Vector3d;
  const double k = kJointErp / step_s_;
  RigidBody &a = rigid_body(pair.a), &b = rigid_body(pair.b);
  const Eigen::Matrix3d &R_a = a.R_WB(), &R_b = b.R_WB();
  const Eigen::Matrix3d R_a0 = pair.X_WA.linear(), R_b0 = pair.X_WB.linear();
  const Vector3d apart = b.p_W() - a.p_W();
  const Vector3d joined = pair.X_WB.translation() - pair.X_WA.translation();
  // Errors against the relative pose when joined: of position, and the small rotation between them.
  // Error of position in world axes; ERP removes a share of it in each step (Baumgarte 1972
  // stabilisation).
  const Vector3d off = apart - R_a * (R_a0.transpose() * joined);
  // Rotation vector of a small rotation: half the sum of cross products of the axes, as it is and
  // as wanted.
  const Eigen::Matrix3d R_a_wanted = R_b * R_b0.transpose() * R_a0;
  Vector3d turn = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) turn += 0.5 * R_a.col(i).cross(R_a_wanted.col(i));
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = Vector3d::Unit(i);
    system.add_joint_row(RowSide::of_point(a, axis, apart),
                         RowSide::of_point(b, -axis, Vector3d::Zero()), k * off[i], kJointCfm,
                         pair.forces[static_cast<std::size_t>(i)]);
  }
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = Vector3d::Unit(i);
    system.add_joint_row(RowSide::of_turn(a, axis), RowSide::of_turn(b, -axis), k * turn[i],
                         kJointCfm, pair.forces[static_cast<std::size_t>(i) + 3]);
  }
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
