#include "world/physics/simplification/composites.hpp"

#include <algorithm>

namespace aprsim::physics {

Composites::Composites(std::span<FreeBody> bodies, const Eigen::Vector3d& gravity_W)
    : bodies_(bodies), gravity_W_(gravity_W), members_(bodies.size()) {
  moved_.reserve(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    members_[i].root = static_cast<int>(i);
    members_[i].carried = bodies[i].mass;
  }
}

/// Into the root's list, which ascends.
void Composites::insert(int root, int member) {
  int before = root;
  while (next(before) >= 0 && next(before) < member) before = next(before);
  at(member).next = next(before);
  at(before).next = member;
  at(member).root = root;
  // The relative pose is frozen here; members follow their root by it exactly, without drift.
  at(member).X_RB = body(root).X_WB.inverse() * body(member).X_WB;
}

bool Composites::rests_on(int body, int below) const {
  while (body >= 0 && body != below) body = parent(body);
  return body == below;
}

void Composites::attach(int child, int parent, const ContactWrenchCone& cone) {
  // A composite is a tree in which every child rests on one parent. The list of a root holds the
  // tree's bodies in ascending order.
  // The child's whole list goes over to the parent's root.
  moved_.clear();
  for (int m = child; m >= 0; m = next(m)) moved_.push_back(m);
  at(child).parent = parent;
  at(child).cone = cone;
  const int to = root(parent);
  for (const int m : moved_) insert(to, m);
  ++children_;
  update_inertia(to);
}

void Composites::detach(int child) {
  const int from = root(child);
  // Bodies that rest on the freed one stay merged with it: their own contacts are not overstressed.
  // Take the child and all that rests on it out of the list, and make it a list of its own.
  moved_.clear();
  for (int m = from; next(m) >= 0;) {
    const int candidate = next(m);
    if (rests_on(candidate, child)) {
      at(m).next = next(candidate);
      if (candidate != child) moved_.push_back(candidate);
    } else {
      m = candidate;
    }
  }
  at(child).root = child;
  at(child).parent = -1;
  at(child).next = -1;
  at(child).X_RB.setIdentity();
  for (const int m : moved_) insert(child, m);
  --children_;
  update_inertia(from);
  FreeBody& free = body(child);
  // While merged the child's own rigid body was idle; it resumes from the pose that its root gave
  // it.
  free.body.set_orientation(Eigen::Matrix3d(free.X_WB.linear()));
  update_inertia(child);
}

/// Composite inertia of each member: itself and all that rests on it. The root's rigid body moves
/// the whole.
void Composites::update_inertia(int root) {
  for (int m = root; m >= 0; m = next(m)) {
    MassProperties total = body(m).mass;
    for (int k = root; k >= 0; k = next(k)) {
      if (k == m || !rests_on(k, m)) continue;
      // Composite rigid body (Featherstone 2008, ch. 6.2): parallel axes for each body of the
      // subtree.
      total = combined(total, body(k).mass, at(m).X_RB.inverse() * at(k).X_RB);
    }
    at(m).carried = total;
  }
  body(root).set_carried_mass(at(root).carried);
}

void Composites::move_members(int root) {
  const FreeBody& lead = body(root);
  for (int m = next(root); m >= 0; m = next(m)) {
    FreeBody& free = body(m);
    free.X_WB = lead.X_WB * at(m).X_RB;
    free.omega_W = lead.omega_W;
    // Rigid motion: v = v_lead + omega x r.
    free.v_com_W = lead.velocity_at(free.com_W());
    free.update_bounds();
  }
}

Wrench Composites::required_wrench(int child, const RigidMotion& motion) const {
  const Eigen::Isometry3d& X = body(child).X_WB;
  const MassProperties& load = at(child).carried;
  const Eigen::Vector3d r = X * load.com - motion.origin_W;
  // Acceleration of the load's centre of mass.
  const Eigen::Vector3d accel =
      // Relative acceleration on a rigid body: linear, Euler and centripetal term.
      motion.accel_W + motion.alpha_W.cross(r) + motion.omega_W.cross(motion.omega_W.cross(r));
  // In the child's frame: force, then Euler's equation about the centre of mass, moved to the
  // origin.
  const auto R_BW = X.linear().transpose();
  const Eigen::Vector3d omega = R_BW * motion.omega_W;
  Wrench wrench;
  wrench.force = R_BW * (load.mass_kg * (accel - gravity_W_));
  wrench.moment = load.inertia * (R_BW * motion.alpha_W) + omega.cross(load.inertia * omega) +
                  load.com.cross(wrench.force);
  return wrench;
}

/// The list of a root: itself, then its members in ascending order, whose parents lead to it.
bool Composites::has_valid_list(int root, std::vector<char>& listed) const {
  const int count = static_cast<int>(members_.size());
  for (int m = root; m >= 0; m = next(m)) {
    if (m >= count || listed[static_cast<std::size_t>(m)] != 0 || at(m).root != root) return false;
    listed[static_cast<std::size_t>(m)] = 1;
    if (m != root && (parent(m) < 0 || parent(m) >= count || at(parent(m)).root != root)) {
      return false;
    }
    if (m != root && next(m) >= 0 && next(m) <= m) return false;
  }
  for (int m = next(root); m >= 0; m = next(m)) {
    int below = m;
    for (int steps = 0; below >= 0 && below != root; below = parent(below)) {
      if (++steps > count) return false;
    }
    if (below != root) return false;
  }
  return true;
}

bool Composites::is_consistent() const {
  std::vector<char> listed(members_.size(), 0);
  int children = 0;
  for (int i = 0; i < static_cast<int>(members_.size()); ++i) {
    if (!(at(i).carried.mass_kg > 0)) return false;
    if (parent(i) >= 0) ++children;
    if (at(i).root != i) continue;
    if (parent(i) >= 0 || !has_valid_list(i, listed)) return false;
  }
  return children == children_ &&
         std::ranges::all_of(listed, [](char is_listed) { return is_listed != 0; });
}

void Composites::restore(const Composites& from) {
  members_ = from.members_;
  children_ = from.children_;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (members_[i].root == static_cast<int>(i)) bodies_[i].set_carried_mass(members_[i].carried);
  }
}

}  // namespace aprsim::physics
