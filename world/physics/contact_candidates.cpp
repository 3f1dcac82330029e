#include "world/physics/contact_candidates.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics::detail {
namespace {

constexpr int kMaxPoints = 4;
/// Depths closer than this count as equal: the order of the candidates, which follows body-fixed
/// features, then decides instead of rounding noise.
constexpr double kSameDepth = 2e-6;
/// Two candidates nearer than this (in the metric below) are one.
constexpr double kSamePoint2 = 1e-5 * 1e-5;
/// Length that turns a difference of unit normals into a distance.
constexpr double kNormalLength = 0.01;

double distance2(const Candidate& a, const Candidate& b) {
  return (a.p - b.p).squaredNorm() + kNormalLength * kNormalLength * (a.n - b.n).squaredNorm();
}

void emit(const Candidate& c, const Emission& to) {
  Contact contact;
  contact.a = to.a;
  contact.b = to.b;
  contact.p_W = to.X_WS * c.p;
  contact.n_W = (to.flip ? -1.0 : 1.0) * (to.X_WS.linear() * c.n);
  contact.depth_m = c.depth;
  contact.pair = to.pair;
  to.out.push_back(contact);
}

/// Emits up to four of the candidates listed in `index`.
void emit_spread(const Candidates& all, const int* index, int count, const Emission& to) {
  if (count == 0) return;
  std::array<double, Candidates::kCapacity> nearest;  // squared distance to the chosen ones
  double deepest = 0;
  for (int i = 0; i < count; ++i) deepest = std::max(deepest, all[index[i]].depth);
  int pick = 0;
  while (all[index[pick]].depth < deepest - kSameDepth) ++pick;
  nearest.fill(1e30);
  for (int n = 0; n < kMaxPoints; ++n) {
    emit(all[index[pick]], to);
    int next = -1;
    double best = kSamePoint2;
    for (int i = 0; i < count; ++i) {
      auto& d = nearest[static_cast<std::size_t>(i)];
      d = std::min(d, distance2(all[index[i]], all[index[pick]]));
      if (d > best * (1 + 1e-9)) {
        best = d;
        next = i;
      }
    }
    if (next < 0) return;
    pick = next;
  }
}

}  // namespace

void Candidates::replace_shallowest(const Candidate& c) {
  auto* shallowest =
      std::min_element(items_.begin(), items_.end(),
                       [](const Candidate& a, const Candidate& b) { return a.depth < b.depth; });
  if (shallowest->depth < c.depth) *shallowest = c;
}

void emit_reduced(const Candidates& candidates, const Emission& to) {
  std::array<int, Candidates::kCapacity> index;
  for (int i = 0; i < candidates.size(); ++i) index[static_cast<std::size_t>(i)] = i;
  emit_spread(candidates, index.data(), candidates.size(), to);
}

void emit_reduced_by_axis(const Candidates& candidates, const Eigen::Vector3d& u,
                          const Emission& to) {
  constexpr double kFlat = 0.8;  // steeper than any lead-in cone
  std::array<int, Candidates::kCapacity> flat, wall;
  int flats = 0, walls = 0;
  for (int i = 0; i < candidates.size(); ++i) {
    if (std::abs(candidates[i].n.dot(u)) > kFlat) {
      flat[static_cast<std::size_t>(flats++)] = i;
    } else {
      wall[static_cast<std::size_t>(walls++)] = i;
    }
  }
  emit_spread(candidates, flat.data(), flats, to);
  emit_spread(candidates, wall.data(), walls, to);
}

}  // namespace aprsim::physics::detail
