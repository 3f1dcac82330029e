#include "world/physics/contacts/contact_cache.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "world/base/simd/vector_clones.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;

Isometry3d pose_in_b(const ContactCache::Pair& pair) {
  if (pair.body_b == nullptr) return pair.body_a->X_WB;
  return pair.body_b->X_WB.inverse(Eigen::Isometry) * pair.body_a->X_WB;
}

/// Upper bound of the displacement of any of the body's points between two poses.
double moved_m(const FreeBody& body, const Isometry3d& from, const Isometry3d& to) {
  // A small rotation changes its matrix by sqrt(2) times its angle.
  // |R1 - R2|_F = 2 sqrt(2) sin(angle / 2), about sqrt(2) angle.
  const double angle = std::sqrt(0.5) * (to.linear() - from.linear()).norm();
  return (to * body.mass.com - from * body.mass.com).norm() + body.radius_m * angle;
}

}  // namespace

ContactCache::Entry* ContactCache::find(BodyIndex a, int on) {
  for (int i = newest_[static_cast<std::size_t>(a)]; i >= 0;) {
    Entry& entry = entries_[static_cast<std::size_t>(i)];
    if (entry.manifold.on == on) return &entry;
    i = entry.older;
  }
  return nullptr;
}

/// The pair's own entry, one that is free, or a new one.
ContactCache::Entry& ContactCache::slot_for(BodyIndex a, int on) {
  if (Entry* own = find(a, on)) return *own;
  int& newest = newest_[static_cast<std::size_t>(a)];
  // Entries of pairs that separated are reused, which bounds the memory by the largest number of
  // simultaneous pairs.
  for (int i = newest; i >= 0; i = entries_[static_cast<std::size_t>(i)].older) {
    if (!is_fresh(entries_[static_cast<std::size_t>(i)]))
      return entries_[static_cast<std::size_t>(i)];
  }
  Entry& added = entries_.emplace_back();
  added.older = newest;
  newest = static_cast<int>(entries_.size()) - 1;
  return added;
}

APRSIM_VECTOR_CLONES bool ContactCache::append(const Pair& pair, std::vector<Contact>& out) {
  Entry* entry = find(pair.a, pair.on);
  if (entry == nullptr || !is_fresh(*entry)) return false;
  const Manifold& manifold = entry->manifold;
  const Isometry3d X_BA = pose_in_b(pair);
  // Persistent manifold: points move with the bodies and their depth is updated, until the motion
  // since detection exceeds the threshold. The threshold is relative to detection, so that errors
  // do not accumulate.
  if (!(moved_m(*pair.body_a, manifold.X_BA, X_BA) < kReuseDistance)) return false;
  entry->used = step_;
  for (const Point& point : manifold.points) {
    Contact& contact = out.emplace_back();
    contact.a = pair.a;
    contact.b = pair.body_b == nullptr ? kGround : pair.on;
    contact.pair = point.pair;
    contact.p_W = point.p_B;
    contact.n_W = point.n_B;
    if (pair.body_b != nullptr) {
      contact.p_W = pair.body_b->X_WB * point.p_B;
      contact.n_W = pair.body_b->X_WB.linear() * point.n_B;
    }
    // First-order update: a point of a that moves along the normal opens the contact by as much.
    contact.depth_m = point.depth_m - point.n_B.dot(X_BA * point.p_A - point.p_B);
  }
  return true;
}

void ContactCache::store(const Pair& pair, const std::vector<Contact>& out, std::size_t first) {
  Entry& entry = slot_for(pair.a, pair.on);
  Manifold& manifold = entry.manifold;
  entry.used = step_;
  manifold.a = pair.a;
  manifold.on = pair.on;
  manifold.X_BA = pose_in_b(pair);
  const Isometry3d X_AB = manifold.X_BA.inverse(Eigen::Isometry);
  Isometry3d X_BW = Isometry3d::Identity();
  if (pair.body_b != nullptr) X_BW = pair.body_b->X_WB.inverse(Eigen::Isometry);
  manifold.points.clear();
  for (std::size_t i = first; i < out.size(); ++i) {
    Point& point = manifold.points.emplace_back();
    point.p_B = X_BW * out[i].p_W;
    point.n_B = X_BW.linear() * out[i].n_W;
    point.p_A = X_AB * point.p_B;
    point.depth_m = out[i].depth_m;
    point.pair = out[i].pair;
  }
}

ContactCache::State ContactCache::save() const {
  State state;
  // Only entries of the last step are state. Their order in memory depends on history and must not
  // enter it.
  for (const Entry& entry : entries_) {
    if (entry.used == step_) state.push_back(entry.manifold);
  }
  std::sort(state.begin(), state.end(), [](const Manifold& p, const Manifold& q) {
    return std::tuple(p.a, p.on) < std::tuple(q.a, q.on);
  });
  return state;
}

void ContactCache::restore(const State& state) {
  for (Entry& entry : entries_) entry.used = 0;
  step_ = 2;
  for (const Manifold& manifold : state) {
    if (manifold.a < 0 || manifold.a >= static_cast<int>(newest_.size())) continue;
    Entry& entry = slot_for(manifold.a, manifold.on);
    entry.manifold = manifold;
    entry.used = step_;
  }
}

}  // namespace aprsim::physics
