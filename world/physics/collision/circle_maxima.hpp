#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <boost/math/tools/roots.hpp>

/// Finding the deepest points around a circle. Internal to contact generation.
namespace aprsim::physics::detail {

inline constexpr int kRingSamples = 24;
inline constexpr double kSampleAngle = 0.26179938779914943653855361527329;  // 2 pi / 24
inline constexpr double kSampleStep = 0.26330499517482915;                  // 2 tan(pi / 24)

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

/// A point of a circle, and its change with the step along it.
struct CirclePoint {
  Eigen::Vector3d p, by_step;
};

/// A circle by its centre, the radius on which the samples start, and the radius a quarter turn on.
struct CircleBasis {
  Eigen::Vector3d c, a1, a2;
  [[nodiscard]] Eigen::Vector3d sample(int i) const {
    const Direction& d = kSampleDirections[static_cast<std::size_t>(i)];
    return c + d.c * a1 + d.s * a2;
  }
  /// From sample i on by a step: twice the tangent of half the angle, which spares sine and cosine.
  [[nodiscard]] CirclePoint at(int i, double step) const {
    const Direction& d = kSampleDirections[static_cast<std::size_t>(i)];
    const Eigen::Vector3d out = d.c * a1 + d.s * a2, on = d.c * a2 - d.s * a1;
    const double quarter2 = 0.25 * step * step, scale = 1 / (1 + quarter2);
    const double cosine = (1 - quarter2) * scale, sine = step * scale;
    return {c + cosine * out + sine * on, scale * (cosine * on - sine * out)};
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
  double slope = 0;  ///< of the depth, by the step
  double turn = 0;   ///< of the same sign, and straighter near an axis
  bool left_out = false;  ///< of what the surfaces are those of: the depth jumps where this ends
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

/// The maximum of the depth between the samples beside sample i, to half a millionth of a step: by
/// secants of the slope on one surface, by tangents (Kelley's cutting planes) where the nearest
/// surface changes, at the edge of what is left out, and by halves where none of these gains. False
/// where all there is outside. `radius`: the circle's own, no depth is more curved.
template <class F>
bool refine_maximum(const CircleBasis& circle, int i, double radius, const F& way_at,
                    RingMaximum& best) {
  constexpr double kSame = 5e-7;
  constexpr int kMost = 40, kStuck = 4;
  struct Look {
    double step = 0;
    SlopedWay way;
  };
  best.way.depth = -1e30;
  const auto look = [&](double step) {
    const CirclePoint at = circle.at(i, step);
    const Look found{step, way_at(at)};
    if (found.way.depth > best.way.depth) best = {at, found.way};
    return found;
  };
  Look lo = look(0), hi = lo;
  if (lo.way.slope == 0) return best.way.depth > 0;
  (lo.way.slope > 0 ? hi : lo) = look(lo.way.slope > 0 ? kSampleStep : -kSampleStep);
  int on_one_side = 0;  // how often in a row lo (positive) or hi has moved, the last time by:
  double advance = 0;
  for (int pass = 0; pass < kMost; ++pass) {
    const double width = hi.step - lo.step, rise = lo.way.slope, fall = hi.way.slope;
    if (width < kSame) break;
    const auto bend = [radius](double way) { return 0.5 * radius * way * way; };
    double on = 0.5 * width;
    if (rise > 0 && fall < 0 && !(lo.way.left_out && hi.way.left_out)) {
      double wanted = 0, highest = 0;
      bool last = false;
      if (lo.way.left_out) {
        wanted = -lo.way.depth / rise;
        highest = hi.way.depth - fall * width + bend(width);
      } else if (hi.way.left_out) {
        wanted = width - hi.way.depth / fall;
        highest = lo.way.depth + rise * width + bend(width);
      } else {
        const double tangents = (hi.way.depth - lo.way.depth - fall * width) / (rise - fall);
        highest = lo.way.depth + rise * tangents + bend(std::max(tangents, width - tangents));
        const bool kink = lo.way.kind != hi.way.kind;
        wanted = kink ? tangents : width * lo.way.turn / (lo.way.turn - hi.way.turn);
        last = kink ? bend(width) < kSame * (rise - fall) : width * width < kSame;
      }
      if (highest < 0) return false;
      const double least = 0.5 * kSame, most = width - least;
      if (last) {
        look(lo.step + std::clamp(wanted, least, most));
        break;
      }
      // Where one side comes near and the other does not, a step too far brings that in.
      if (on_one_side > 0) {
        wanted = wanted < least ? advance : on_one_side > 1 ? 2 * wanted : wanted;
      } else if (on_one_side < 0) {
        const double back = width - wanted;
        wanted = width - (back < least ? advance : on_one_side < -1 ? 2 * back : back);
      }
      if (std::abs(on_one_side) < kStuck) on = std::clamp(wanted, least, most);
    }
    const Look found = look(lo.step + on);
    if (found.way.slope == 0) break;
    bool is_lo = found.way.slope > 0;
    // Over a valley: on the higher side of it.
    if (found.way.depth < (is_lo ? lo : hi).way.depth) is_lo = lo.way.depth < hi.way.depth;
    advance = is_lo ? on : width - on;
    (is_lo ? lo : hi) = found;
    on_one_side = is_lo ? std::max(on_one_side, 0) + 1 : std::min(on_one_side, 0) - 1;
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
        [&](double step) { return f(circle.at(i, step).p); }, 0.0, kSampleStep, lo, hi,
        [](double x, double y) { return y - x < 1e-11; }, passes);
    emit(circle.at(i, 0.5 * (bracket.first + bracket.second)).p);
    --most;
  }
}

}  // namespace aprsim::physics::detail
