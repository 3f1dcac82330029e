#pragma once

#include <algorithm>

#include <Eigen/Geometry>

#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/nearness.hpp"

namespace aprsim::physics::detail {

/// The segment of a capsule: from middle - half to middle + half, in the other shape's frame.
struct Segment {
  Eigen::Vector3d middle, half;
  [[nodiscard]] Eigen::Vector3d at(double t) const { return middle + t * half; }
};

/// Calls touch(t, nearness) where a capsule with this segment may touch a convex shape: at the ends
/// of where it lies along a face or side, and where it is nearest. `near_to(p)`: see nearness.hpp.
/// The distance along the segment is convex: its derivative is bisected.
template <class NearTo, class Touch>
void along_segment(const Segment& segment, const NearTo& near_to, const Touch& touch) {
  constexpr double kSameNormal = 1 - 1e-7;  // cosine
  constexpr int kHalvings = 50;
  const auto near = [&](double t) { return near_to(segment.at(t)); };
  if (segment.half.isZero(0)) return touch(0, near(0));
  const auto slope = [&](double t) { return near(t).out.dot(segment.half); };
  double low = -1, high = 1, nearest = 0;
  if (slope(low) >= 0) {
    nearest = low;
  } else if (slope(high) <= 0) {
    nearest = high;
  } else {
    for (int i = 0; i < kHalvings; ++i) {
      nearest = 0.5 * (low + high);
      const double value = slope(nearest);
      if (value == 0) break;
      (value < 0 ? low : high) = nearest;
    }
  }
  const Nearness middle = near(nearest);
  for (const double end : {-1.0, 1.0}) {
    if (end == nearest) continue;
    const auto is_along = [&](double t) { return near(t).out.dot(middle.out) > kSameNormal; };
    double inside = nearest, outside = end;
    if (is_along(end)) inside = end;
    for (int i = 0; i < kHalvings && inside != end; ++i) {
      const double t = 0.5 * (inside + outside);
      (is_along(t) ? inside : outside) = t;
    }
    touch(inside, near(inside));
  }
  touch(nearest, middle);
}

/// Contacts of a capsule with a convex shape, in the shape's frame, normals into the capsule.
template <class NearTo>
void capsule_on(const Segment& segment, double radius_m, const NearTo& near_to, Candidates& out) {
  along_segment(segment, near_to, [&](double t, const Nearness& near) {
    out.add(segment.at(t) - radius_m * near.out, near.out, radius_m - near.distance);
  });
}

}  // namespace aprsim::physics::detail
