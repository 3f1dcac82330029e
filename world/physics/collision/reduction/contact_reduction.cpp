#include "world/physics/collision/reduction/contact_reduction.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics::detail {
namespace {

using Eigen::Vector3d;

constexpr int kMaxPoints = 4;
constexpr std::size_t kMaxFacePoints = 8;
/// Depths closer than this count as equal: the order of the candidates, which follows body-fixed
/// features, then decides instead of rounding noise.
constexpr double kSameDepth = 2e-6;
/// Two candidates nearer than this (in the metric below) are one.
constexpr double kSamePoint2 = 1e-5 * 1e-5;
/// Length that turns a difference of unit normals into a distance.
constexpr double kNormalLength = 0.01;

double distance2(const Candidate& a, const Candidate& b) {
  // Points of different direction are far apart in this metric even at the same place: both are
  // needed to hold a body in a corner.
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

using Index = std::array<int, Candidates::kCapacity>;

/// Some of a list's candidates, by index.
struct Selection {
  Index index;
  int count = 0;
  void push(int i) { index[static_cast<std::size_t>(count++)] = i; }
  [[nodiscard]] int at(int k) const { return index[static_cast<std::size_t>(k)]; }
};

/// The first that is as deep as the deepest.
int deepest_of(const Candidates& all, const Selection& from) {
  double deepest = 0;
  for (int k = 0; k < from.count; ++k) deepest = std::max(deepest, all[from.at(k)].depth);
  int pick = 0;
  while (all[from.at(pick)].depth < deepest - kSameDepth) ++pick;
  return from.at(pick);
}

/// The candidate with the highest score above `least`, the earlier one when nearly equal; -1: none.
template <class Score>
int best_of(const Selection& from, double least, const Score& score) {
  int best = -1;
  for (int k = 0; k < from.count; ++k) {
    const double value = score(from.at(k));
    if (value > least * (1 + 1e-9)) {
      least = value;
      best = from.at(k);
    }
  }
  return best;
}

constexpr double kWidth = 1e-6;  // of the smallest triangle worth keeping [m]

/// Adds the point that enlarges the polygon the most, until it has as many corners as wanted. The
/// polygon begins with four corners, counter-clockwise around n.
void emit_more(const Candidates& all, const Selection& from, std::array<int, 4> corners,
               const Emission& to) {
  std::array<int, kMaxFacePoints> ring;
  std::size_t count = corners.size();
  std::copy(corners.begin(), corners.end(), ring.begin());
  const Vector3d n = all[ring[0]].n;
  while (count < ring.size()) {
    std::size_t after = 0;
    double most = 0;
    int best = -1;
    for (std::size_t k = 0; k < count; ++k) {
      const Vector3d& p = all[ring[k]].p;
      const Vector3d side = all[ring[(k + 1) % count]].p - p;
      const int found = best_of(from, std::max(most, kWidth * side.norm()),
                                [&](int i) { return n.dot((all[i].p - p).cross(side)); });
      if (found < 0) continue;
      best = found;
      after = k + 1;
      most = n.dot((all[found].p - p).cross(side));
    }
    if (best < 0) return;
    emit(all[best], to);
    std::copy_backward(ring.begin() + static_cast<std::ptrdiff_t>(after),
                       ring.begin() + static_cast<std::ptrdiff_t>(count),
                       ring.begin() + static_cast<std::ptrdiff_t>(count + 1));
    ring[after] = best;
    ++count;
  }
}

/// Points of one plane: four corners of about the largest polygon, the deepest first (Gregorius,
/// "Robust Contact Creation", GDC 2015).
void emit_polygon(const Candidates& all, const Selection& from, const Emission& to) {
  const int a = deepest_of(all, from);
  emit(all[a], to);
  const Vector3d pa = all[a].p;
  // The point farthest from it.
  const int b = best_of(from, kSamePoint2, [&](int i) { return (all[i].p - pa).squaredNorm(); });
  if (b < 0) return;
  emit(all[b], to);
  const Vector3d& n = all[a].n;
  const Vector3d ab = all[b].p - pa, across = n.cross(ab).normalized();
  const auto beside = [&](int i) { return across.dot(all[i].p - pa); };
  // The point farthest from the line through both.
  const int c = best_of(from, kWidth, [&](int i) { return std::abs(beside(i)); });
  if (c < 0) return;
  emit(all[c], to);
  // The fourth adds the most area to the triangle.
  const double sign = beside(c) > 0 ? 1 : -1;
  const Vector3d pb = all[b].p, pc = all[c].p;
  const auto added = [&](int i) {
    const Vector3d& p = all[i].p;
    const double beyond_ab = -sign * n.dot((pb - pa).cross(p - pa));
    const double beyond_bc = -sign * n.dot((pc - pb).cross(p - pb));
    const double beyond_ca = -sign * n.dot((pa - pc).cross(p - pc));
    return std::max({beyond_ab, beyond_bc, beyond_ca});
  };
  const int d = best_of(from, kWidth * ab.norm(), added);
  if (d < 0) return;
  emit(all[d], to);
  if (!to.many) return;
  // In order around n: by their angles about the middle of the four.
  std::array<int, 4> corners{a, b, c, d};
  const Vector3d middle = 0.25 * (pa + pb + pc + all[d].p);
  const Vector3d x = (pa - middle).normalized(), y = n.cross(x);
  const auto angle = [&](int i) {
    const Vector3d from_middle = all[i].p - middle;
    return std::atan2(y.dot(from_middle), x.dot(from_middle));
  };
  std::sort(corners.begin(), corners.end(), [&](int i, int k) { return angle(i) < angle(k); });
  emit_more(all, from, corners, to);
}

/// Up to four that are deepest and farthest from each other in place and direction.
void emit_spread(const Candidates& all, const Selection& from, const Emission& to) {
  std::array<double, Candidates::kCapacity> nearest;  // squared distance to the chosen ones
  // Farthest point sampling (Gonzalez 1985): each pick maximises the distance to the picks so far.
  nearest.fill(1e30);
  int pick = deepest_of(all, from);
  for (int n = 0; n < kMaxPoints && pick >= 0; ++n) {
    emit(all[pick], to);
    pick = best_of(from, kSamePoint2, [&](int i) {
      auto& d = nearest[static_cast<std::size_t>(i)];
      d = std::min(d, distance2(all[i], all[pick]));
      return d;
    });
  }
}

/// Removes points that lie steeply above another one of the same body: the plane touches the lower
/// one first, unless the body rotates far. Both edges of a chamfered rim may be inside at a
/// predicted pose.
Selection without_steep(const Candidates& all, const Selection& from) {
  constexpr double kFlatAll = 1e-5, kSteep = 0.5;  // [m], sine of an angle
  double deepest = 0, shallowest = 1e30;
  for (int k = 0; k < from.count; ++k) {
    deepest = std::max(deepest, all[from.at(k)].depth);
    shallowest = std::min(shallowest, all[from.at(k)].depth);
  }
  if (deepest - shallowest < kFlatAll) return from;
  Selection kept;
  for (int k = 0; k < from.count; ++k) {
    const Candidate& own = all[from.at(k)];
    bool steep = false;
    for (int m = 0; m < from.count && !steep; ++m) {
      const Candidate& other = all[from.at(m)];
      const double higher = other.depth - own.depth;
      steep =
          higher > kFlatAll && higher * higher > kSteep * kSteep * (other.p - own.p).squaredNorm();
    }
    if (!steep) kept.push(from.at(k));
  }
  return kept;
}

void emit_some(const Candidates& all, const Selection& from, const Emission& to) {
  constexpr double kSameDirection = 0.99;
  if (from.count == 0) return;
  // One plane, or surfaces of several directions.
  for (int k = 1; k < from.count; ++k) {
    if (all[from.at(k)].n.dot(all[from.at(0)].n) < kSameDirection) {
      emit_spread(all, from, to);
      return;
    }
  }
  emit_polygon(all, without_steep(all, from), to);
}

bool is_tunnelling(const Candidates& all, int i) {
  for (int k = 0; k < all.size(); ++k) {
    if (physics::is_tunnelling(all[i].depth, all[i].n, all[k].depth, all[k].n)) return true;
  }
  return false;
}

}  // namespace

void Candidates::replace_shallowest(const Candidate& c) {
  auto* shallowest =
      std::min_element(items_.begin(), items_.end(),
                       [](const Candidate& a, const Candidate& b) { return a.depth < b.depth; });
  if (shallowest->depth < c.depth) *shallowest = c;
}

void emit_reduced(const Candidates& candidates, const Emission& to) {
  Selection all;
  for (int i = 0; i < candidates.size(); ++i) {
    if (!is_tunnelling(candidates, i)) all.push(i);
  }
  emit_some(candidates, all, to);
}

void emit_reduced_by_axis(const Candidates& candidates, const Eigen::Vector3d& u,
                          const Emission& to) {
  constexpr double kFlat = 0.8;  // steeper than any lead-in cone
  Selection flat, wall;
  for (int i = 0; i < candidates.size(); ++i) {
    if (is_tunnelling(candidates, i)) continue;
    (std::abs(candidates[i].n.dot(u)) > kFlat ? flat : wall).push(i);
  }
  emit_some(candidates, flat, to);
  emit_some(candidates, wall, to);
}

void emit_reduced_by_direction(const Candidates& candidates, const Emission& to) {
  constexpr double kSameDirection = 0.99;
  std::array<bool, Candidates::kCapacity> taken{};
  for (int i = 0; i < candidates.size(); ++i) {
    if (taken[static_cast<std::size_t>(i)] || is_tunnelling(candidates, i)) continue;
    Selection same;
    for (int k = i; k < candidates.size(); ++k) {
      bool& is_taken = taken[static_cast<std::size_t>(k)];
      if (is_taken || candidates[k].n.dot(candidates[i].n) < kSameDirection) continue;
      if (is_tunnelling(candidates, k)) continue;
      same.push(k);
      is_taken = true;
    }
    emit_polygon(candidates, without_steep(candidates, same), to);
  }
}

}  // namespace aprsim::physics::detail
