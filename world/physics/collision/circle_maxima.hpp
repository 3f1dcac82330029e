#pragma once

#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <boost/math/tools/roots.hpp>

/// Finding the deepest points around a circle. Internal to contact generation.
namespace aprsim::physics::detail {

inline constexpr int kRingSamples = 24;
inline constexpr double kSampleAngle = 0.26179938779914943653855361527329;  // 2 pi / 24

struct Direction {
  double c = 1, s = 0;
};

/// Cosine and sine of the sample angles.
inline const std::array<Direction, kRingSamples> kSampleDirections = [] {
  std::array<Direction, kRingSamples> d;
  for (int i = 0; i < kRingSamples; ++i) {
    d[static_cast<std::size_t>(i)] = {std::cos(kSampleAngle * i), std::sin(kSampleAngle * i)};
  }
  return d;
}();

/// A point of a circle, and how fast it moves along it, by the angle.
struct CirclePoint {
  Eigen::Vector3d p, by_angle;
};

/// A circle by its centre, the radius on which the samples start, and the radius a quarter turn on.
struct CircleBasis {
  Eigen::Vector3d c, a1, a2;
  [[nodiscard]] Eigen::Vector3d sample(int i) const {
    const Direction& d = kSampleDirections[static_cast<std::size_t>(i)];
    return c + d.c * a1 + d.s * a2;
  }
  /// From sample i on by an angle of at most that between samples, by Taylor's series.
  [[nodiscard]] CirclePoint at(int i, double angle) const {
    const Direction& d = kSampleDirections[static_cast<std::size_t>(i)];
    const Eigen::Vector3d out = d.c * a1 + d.s * a2, on = d.c * a2 - d.s * a1;
    const double x2 = angle * angle;
    const double s =
        angle * (1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42 * (1 - x2 / 72 * (1 - x2 / 110)))));
    const double co =
        1 - x2 / 2 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56 * (1 - x2 / 90 * (1 - x2 / 132)))));
    return {c + co * out + s * on, co * on - s * out};
  }
};

/// Signed way out of a solid at one point: positive inside. The kind tells which of the solid's
/// surfaces is the nearest; where it changes along the circle the depth has a kink.
struct WayOut {
  double depth = 0;
  int kind = 0;
};

/// With its change along the circle.
struct SlopedWay : WayOut {
  double slope = 0;  ///< of the depth, by the angle
  double turn = 0;   ///< of the same sign, and straighter near an axis
};

using RingWays = std::array<WayOut, kRingSamples>;

[[nodiscard]] inline const WayOut& at_sample(const RingWays& v, int i) {
  return v[static_cast<std::size_t>((i + kRingSamples) % kRingSamples)];
}

/// A point of the circle with its way out.
struct RingMaximum {
  CirclePoint at;
  SlopedWay way;
};

/// The maximum of depth between the samples beside sample i, to half a millionth of its angle: by
/// secants of the slope on one surface, by the tangents where the nearest surface is another one,
/// and by halves where neither gains. False where all there is outside.
template <class F>
bool refine_maximum(const CircleBasis& circle, int i, double radius, const F& way_at,
                    RingMaximum& best) {
  constexpr double kSame = 5e-7;
  constexpr int kMost = 40;
  struct Look {
    double angle = 0;
    SlopedWay way;
  };
  const auto look = [&](double angle) {
    const CirclePoint at = circle.at(i, angle);
    const Look found{angle, way_at(at)};
    if (found.way.depth > best.way.depth) best = {at, found.way};
    return found;
  };
  const CirclePoint middle = circle.at(i, 0);
  best = {middle, way_at(middle)};
  if (best.way.slope == 0) return best.way.depth > 0;
  Look lo{0, best.way}, hi = lo;
  if (best.way.slope > 0) {
    hi = look(kSampleAngle);
  } else {
    lo = look(-kSampleAngle);
  }
  double last_width = 1, width = 1;
  for (int pass = 0; pass < kMost; ++pass) {
    const double before = last_width;
    last_width = width;
    width = hi.angle - lo.angle;
    if (width < kSame) break;
    double angle = lo.angle + 0.5 * width;
    const double rise = lo.way.slope, fall = hi.way.slope;
    if (rise > 0 && fall < 0) {
      const double tangents = (hi.way.depth - lo.way.depth - fall * width) / (rise - fall);
      const double highest = lo.way.depth + rise * tangents + radius * width * width;
      if (highest < 0) return false;
      if (width < 0.5 * before) {
        const bool kink = lo.way.kind != hi.way.kind;
        angle = lo.angle + (kink ? tangents : width * lo.way.turn / (lo.way.turn - hi.way.turn));
        angle = std::fmin(hi.angle - 0.5 * kSame, std::fmax(lo.angle + 0.5 * kSame, angle));
      }
    }
    const Look found = look(angle);
    if (found.way.slope == 0) break;
    const bool rises = found.way.slope > 0;
    if (found.way.depth < (rises ? lo : hi).way.depth) {
      // Over a valley: on the higher side of it.
      (lo.way.depth < hi.way.depth ? lo : hi) = found;
    } else {
      (rises ? lo : hi) = found;
    }
  }
  return best.way.depth > 0;
}

/// Calls emit(RingMaximum) at the refined local maxima that are positive, four at most; when all of
/// the circle is inside, at the deepest sample and the three a quarter turn apart. `radius`: the
/// circle's own.
template <class F, class Emit>
void ring_maxima(const RingWays& v, const CircleBasis& circle, double radius, const F& way_at,
                 const Emit& emit) {
  // A kink may be that much higher than the sample beside it.
  const double gain = 0.5 * kSampleAngle * radius;
  int deepest = 0, inside = 0;
  for (int i = 0; i < kRingSamples; ++i) {
    inside += at_sample(v, i).depth > 0;
    if (at_sample(v, i).depth > at_sample(v, deepest).depth) deepest = i;
  }
  RingMaximum found;
  if (at_sample(v, deepest).depth < -gain) return;
  if (inside == kRingSamples) {
    if (refine_maximum(circle, deepest, radius, way_at, found)) emit(found);
    for (int k = 1; k < 4; ++k) {
      const CirclePoint at = circle.at((deepest + k * kRingSamples / 4) % kRingSamples, 0);
      emit(RingMaximum{at, way_at(at)});
    }
    return;
  }
  int emitted = 0;
  for (int k = 0; k < kRingSamples && emitted < 4; ++k) {
    const int i = (deepest + k) % kRingSamples;
    const WayOut &before = at_sample(v, i - 1), &here = at_sample(v, i),
                 &after = at_sample(v, i + 1);
    if (k > 0 && !(here.depth > before.depth && here.depth >= after.depth)) continue;
    if (here.depth < -gain || !refine_maximum(circle, i, radius, way_at, found)) continue;
    emit(found);
    ++emitted;
  }
}

/// Calls emit(CirclePoint) where v changes sign between neighbouring samples, four times at most; f must
/// agree with v at the samples.
template <class F, class Emit>
void ring_crossings(const std::array<double, kRingSamples>& v, const CircleBasis& circle, const F& f,
                    const Emit& emit) {
  int most = 4;
  for (int i = 0; i < kRingSamples && most > 0; ++i) {
    const double lo = v[static_cast<std::size_t>(i)];
    const double hi = v[static_cast<std::size_t>((i + 1) % kRingSamples)];
    if ((lo > 0) == (hi > 0)) continue;
    std::uintmax_t passes = 20;
    const auto bracket = boost::math::tools::toms748_solve(
        [&](double angle) { return f(circle.at(i, angle).p); }, 0.0, kSampleAngle, lo, hi,
        [](double x, double y) { return y - x < 1e-11; }, passes);
    emit(circle.at(i, 0.5 * (bracket.first + bracket.second)).p);
    --most;
  }
}

}  // namespace aprsim::physics::detail
