#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

/// Finding the deepest points around a circle. Internal to contact generation.
namespace aprsim::physics::detail {

inline constexpr int kRingSamples = 24;
inline constexpr double kSampleAngle = 0.26179938779914943653855361527329;  // 2 pi / 24
inline constexpr double kSampleStep = 0.26330499517482915;                  // 2 tan(pi / 24)

using RingValues = std::array<double, kRingSamples>;

/// Cosines and sines of the sample angles.
struct SampleDirections {
  RingValues c, s;
};
inline const SampleDirections kSampleDirections = [] {
  SampleDirections d;
  for (std::size_t i = 0; i < kRingSamples; ++i) {
    d.c[i] = std::cos(kSampleAngle * static_cast<double>(i));
    d.s[i] = std::sin(kSampleAngle * static_cast<double>(i));
  }
  return d;
}();

/// A point of a circle, and its change with the step along it.
struct CirclePoint {
  Eigen::Vector3d p, by_step;
};

/// A circle from one of its points on.
struct Arc {
  Eigen::Vector3d c, out, on;  ///< centre, radius at that point, radius a quarter turn on
  /// A step along it: twice the tangent of half the angle, which spares sine and cosine.
  [[nodiscard]] CirclePoint at(double step) const {
    const double quarter2 = 0.25 * step * step, scale = 1 / (1 + quarter2);
    const double cosine = (1 - quarter2) * scale, sine = step * scale;
    return {c + cosine * out + sine * on, scale * (cosine * on - sine * out)};
  }
};

/// A circle by its centre, the radius on which the samples start, and the radius a quarter turn on.
struct CircleBasis {
  Eigen::Vector3d c, a1, a2;
  /// One coordinate of all samples.
  [[nodiscard]] RingValues samples(Eigen::Index axis) const {
    const double middle = c(axis), from = a1(axis), on = a2(axis);
    RingValues out;
    for (std::size_t i = 0; i < kRingSamples; ++i) {
      out[i] = middle + kSampleDirections.c[i] * from + kSampleDirections.s[i] * on;
    }
    return out;
  }
  [[nodiscard]] Arc from_sample(int i) const {
    const double cosine = kSampleDirections.c[static_cast<std::size_t>(i)];
    const double sine = kSampleDirections.s[static_cast<std::size_t>(i)];
    return {c, cosine * a1 + sine * a2, cosine * a2 - sine * a1};
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
  double slope = 0;       ///< of the depth, by the step
  double turn = 0;        ///< of the same sign, and straighter near an axis
  bool left_out = false;  ///< of what the surfaces are those of: the depth jumps where this ends
};

[[nodiscard]] inline double greatest(const RingValues& v) {
  std::array<double, 4> most{v[0], v[1], v[2], v[3]};
  for (std::size_t i = 4; i < kRingSamples; i += 4) {
    for (std::size_t k = 0; k < 4; ++k) most[k] = std::max(most[k], v[i + k]);
  }
  return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

[[nodiscard]] inline double at_sample(const RingValues& v, int i) {
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
  const Arc arc = circle.from_sample(i);
  const auto look = [&](double step) {
    const CirclePoint at = arc.at(step);
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
/// the circle is inside, at the deepest sample and the three a quarter turn apart. `v`: depths at
/// the samples. `radius`: the circle's own.
template <class F, class Emit>
void ring_maxima(const RingValues& v, const CircleBasis& circle, double radius, const F& way_at,
                 const Emit& emit) {
  // A kink may be that much higher than the sample beside it.
  const double gain = 0.5 * kSampleAngle * radius;
  const double highest = greatest(v);
  if (highest < -gain) return;
  const auto deepest = static_cast<int>(std::find(v.begin(), v.end(), highest) - v.begin());
  RingMaximum found;
  if (*std::min_element(v.begin(), v.end()) > 0) {
    if (refine_maximum(circle, deepest, radius, way_at, found)) emit(found);
    for (int k = 1; k < 4; ++k) {
      const CirclePoint at =
          circle.from_sample((deepest + k * kRingSamples / 4) % kRingSamples).at(0);
      emit(RingMaximum{at, way_at(at)});
    }
    return;
  }
  int emitted = 0;
  for (int k = 0; k < kRingSamples && emitted < 4; ++k) {
    const int i = (deepest + k) % kRingSamples;
    const double here = at_sample(v, i);
    if (here < -gain) continue;
    if (k > 0 && !(here > at_sample(v, i - 1) && here >= at_sample(v, i + 1))) continue;
    if (!refine_maximum(circle, i, radius, way_at, found)) continue;
    emit(found);
    ++emitted;
  }
}

/// Calls emit(point) where a value changes its sign between neighbouring samples, four times at
/// most. `v`: at the samples; sloped_at(point) has it and its slope by the step. Newton's method,
/// kept between the samples by halves.
template <class F, class Emit>
void ring_crossings(const RingValues& v, const CircleBasis& circle, const F& sloped_at,
                    const Emit& emit) {
  constexpr double kSame = 1e-11;
  constexpr int kMost = 40;
  int most = 4;
  for (int i = 0; i < kRingSamples && most > 0; ++i) {
    const double first = at_sample(v, i), last = at_sample(v, i + 1);
    if ((first > 0) == (last > 0)) continue;
    double lo = 0, hi = kSampleStep, step = kSampleStep * first / (first - last);
    const Arc arc = circle.from_sample(i);
    CirclePoint at = arc.at(step);
    for (int pass = 0; pass < kMost; ++pass) {
      const auto [value, slope] = sloped_at(at);
      ((value > 0) == (first > 0) ? lo : hi) = step;
      double next = step - value / slope;
      if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
      const double moved = std::abs(next - step);
      step = next;
      at = arc.at(step);
      if (moved < kSame) break;
    }
    emit(at.p);
    --most;
  }
}

}  // namespace aprsim::physics::detail
