#pragma once

#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <boost/math/tools/minima.hpp>
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

/// Cosine and sine of any angle, those of a sample exactly: by Taylor's series from the nearest
/// one.
[[nodiscard]] inline Direction direction_at(double angle) {
  const double nearest = std::floor(angle / kSampleAngle + 0.5);
  const double x = angle - kSampleAngle * nearest, x2 = x * x;
  const double s = x * (1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42 * (1 - x2 / 72))));
  const double c = 1 - x2 / 2 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56 * (1 - x2 / 90))));
  int i = static_cast<int>(nearest) % kRingSamples;
  if (i < 0) i += kRingSamples;
  const Direction& at = kSampleDirections[static_cast<std::size_t>(i)];
  return {at.c * c - at.s * s, at.s * c + at.c * s};
}

/// A circle by its centre, the radius on which the samples start, and the radius a quarter turn on.
struct CircleBasis {
  Eigen::Vector3d c, a1, a2;
  [[nodiscard]] Eigen::Vector3d at(double angle) const {
    const Direction d = direction_at(angle);
    return c + d.c * a1 + d.s * a2;
  }
  /// Direction of growing angle there.
  [[nodiscard]] Eigen::Vector3d along(double angle) const {
    const Direction d = direction_at(angle);
    return (d.c * a2 - d.s * a1).normalized();
  }
};

/// Signed way out of a solid at one point: positive inside. The kind tells which of the solid's
/// surfaces is the nearest; where it changes along the circle the depth has a kink.
struct WayOut {
  double depth = 0;
  int kind = 0;
};

using RingWays = std::array<WayOut, kRingSamples>;

[[nodiscard]] inline const WayOut& at_sample(const RingWays& v, int i) {
  return v[static_cast<std::size_t>((i + kRingSamples) % kRingSamples)];
}

/// Angle of the maximum of f less than h from `angle`, to a millionth, by Brent's method.
template <class F>
double brent_maximum(double angle, double h, const F& f) {
  constexpr int kBits = 20;
  const auto outside = [&](double turn) { return -f(angle + turn).depth; };
  return angle + boost::math::tools::brent_find_minima(outside, -h, h, kBits).first;
}

/// The circle's radius, and the least radius of the surfaces it is held against.
struct RingRadius {
  double own = 0, other = 0;

  /// How much higher a maximum can be than the sample beside it: at a kink, and where it is smooth.
  [[nodiscard]] double kink_gain() const { return 0.5 * kSampleAngle * own; }
  [[nodiscard]] double smooth_gain() const {
    const double gain = 0.125 * kSampleAngle * kSampleAngle * own * (1 + own / other);
    return std::fmin(gain, kink_gain());
  }
  /// Do parabolas through the samples follow the depth?
  [[nodiscard]] bool gentle() const { return own < 2 * other; }
};

/// Angle of the maximum near sample i: successive parabolas where the depth is smooth and `gentle`.
/// f must agree with v at the samples. Never worse than the sample itself.
template <class F>
double refine_maximum(const RingWays& v, int i, bool gentle, const F& f) {
  const WayOut &before = at_sample(v, i - 1), &here = at_sample(v, i), &after = at_sample(v, i + 1);
  double h = kSampleAngle, angle = kSampleAngle * i;
  if (!gentle || before.kind != here.kind || after.kind != here.kind) {
    const double kink = brent_maximum(angle, h, f);
    return f(kink).depth > here.depth ? kink : angle;
  }
  double left = before.depth, mid = here.depth, right = after.depth;
  for (int pass = 0; pass < 4; ++pass) {
    const double curvature = left - 2 * mid + right;
    if (!(curvature < 0)) break;
    const double shift = h * std::fmin(0.5, std::fmax(-0.5, 0.5 * (left - right) / curvature));
    if (std::abs(shift) < 1e-5) break;
    const double value = f(angle + shift).depth;
    h *= 0.25;
    if (value > mid) {
      angle += shift;
      mid = value;
    }
    left = f(angle - h).depth;
    right = f(angle + h).depth;
  }
  return angle;
}

/// Calls emit(angle) at the refined local maxima that may be positive, four at most; when all of
/// the circle is inside, at the deepest sample and the three a quarter turn apart.
template <class F, class Emit>
void ring_maxima(const RingWays& v, const RingRadius& r, const F& f, const Emit& emit) {
  const double kink_gain = r.kink_gain(), smooth_gain = r.smooth_gain();
  int deepest = 0, inside = 0;
  for (int i = 0; i < kRingSamples; ++i) {
    inside += at_sample(v, i).depth > 0;
    if (at_sample(v, i).depth > at_sample(v, deepest).depth) deepest = i;
  }
  if (at_sample(v, deepest).depth < -kink_gain) return;
  if (inside == kRingSamples) {
    emit(refine_maximum(v, deepest, r.gentle(), f));
    for (int k = 1; k < 4; ++k) {
      emit(kSampleAngle * ((deepest + k * kRingSamples / 4) % kRingSamples));
    }
    return;
  }
  int emitted = 0;
  for (int k = 0; k < kRingSamples && emitted < 4; ++k) {
    const int i = (deepest + k) % kRingSamples;
    const WayOut &before = at_sample(v, i - 1), &here = at_sample(v, i),
                 &after = at_sample(v, i + 1);
    if (k > 0 && !(here.depth > before.depth && here.depth >= after.depth)) continue;
    const bool smooth = before.kind == here.kind && after.kind == here.kind;
    if (here.depth < -(smooth ? smooth_gain : kink_gain)) continue;
    emit(refine_maximum(v, i, r.gentle(), f));
    ++emitted;
  }
}

/// Calls emit(angle) where v changes sign between neighbouring samples, four times at most; f must
/// agree with v at the samples.
template <class F, class Emit>
void ring_crossings(const std::array<double, kRingSamples>& v, const F& f, const Emit& emit) {
  int most = 4;
  for (int i = 0; i < kRingSamples && most > 0; ++i) {
    const double lo = v[static_cast<std::size_t>(i)];
    const double hi = v[static_cast<std::size_t>((i + 1) % kRingSamples)];
    if ((lo > 0) == (hi > 0)) continue;
    const double a = kSampleAngle * i;
    std::uintmax_t passes = 20;
    const auto bracket = boost::math::tools::toms748_solve(
        f, a, a + kSampleAngle, lo, hi, [](double x, double y) { return y - x < 1e-11; }, passes);
    const double m = 0.5 * (bracket.first + bracket.second);
    emit(m);
    --most;
  }
}

}  // namespace aprsim::physics::detail
