#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>

/// Finding the deepest points around a circle. Internal to contact generation.
namespace aprsim::physics::detail {

inline constexpr int kRingSamples = 24;
inline constexpr double kSampleAngle = 0.26179938779914943653855361527329;  // 2 pi / 24
inline constexpr double kSampleStep = 0.26330499517482915;                  // 2 tan(pi / 24)
/// How far an arc between two samples bulges over its chord, in radii; likewise of a value along
/// the circle whose second derivative by the angle is not under -1. 1 - cos(pi / 24) and
/// (pi / 12)^2 / 8, rounded up.
inline constexpr double kSampleBulge = 0.0086;
/// What bounds allow for rounding [m].
inline constexpr double kBoundSlack = 1e-9;

using RingValues = std::array<double, kRingSamples>;
/// The first sample's value again at the end.
using ClosedRing = std::array<double, kRingSamples + 1>;

/// A bit for each sample.
using RingBits = std::array<std::uint64_t, kRingSamples>;
inline constexpr RingBits kSampleBits = [] {
  RingBits bits{};
  for (std::size_t i = 0; i < kRingSamples; ++i) bits[i] = std::uint64_t{1} << i;
  return bits;
}();
[[nodiscard]] constexpr std::uint64_t joined(const RingBits& bits) {
  std::uint64_t all = 0;
  for (const std::uint64_t bit : bits) all |= bit;
  return all;
}
inline constexpr std::uint64_t kAllSamples = joined(kSampleBits);

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

[[nodiscard]] inline double greatest(const ClosedRing& v) {
  std::array<double, 4> most{v[0], v[1], v[2], v[3]};
  for (std::size_t i = 4; i < kRingSamples; i += 4) {
    for (std::size_t k = 0; k < 4; ++k) most[k] = std::max(most[k], v[i + k]);
  }
  return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

[[nodiscard]] inline double at_sample(const RingValues& v, int i) {
  return v[static_cast<std::size_t>((i + kRingSamples) % kRingSamples)];
}

/// Of two values that run straight from a0 to a1 and from b0 to b1: negative where they are never
/// both positive. One may fall below zero before the other has risen above it.
[[nodiscard]] inline double most_of_both(double a0, double a1, double b0, double b1) {
  const double order = a0 * b1 - a1 * b0;
  return std::min(std::min(std::max(a0, a1), std::max(b0, b1)),
                  std::min(std::max(std::max(a0, b1), -order), std::max(std::max(a1, b0), order)));
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
[[gnu::flatten]] bool refine_maximum(const CircleBasis& circle, int i, double radius,
                                     const F& way_at, RingMaximum& best) {
  constexpr double kSame = 5e-7;
  constexpr int kMost = 40, kStuck = 4;
  struct Look {
    double step = 0;
    SlopedWay way;
  };
  const Arc arc = circle.from_sample(i);
  double deepest = -1e30, best_step = 0;
  const auto look = [&](double step) {
    const Look found{step, way_at(arc.at(step))};
    if (found.way.depth > deepest) {
      deepest = found.way.depth;
      best_step = step;
    }
    return found;
  };
  const auto take_best = [&] {
    if (!(deepest > 0)) return false;
    best.at = arc.at(best_step);
    best.way = way_at(best.at);
    return true;
  };
  // Set by branches, not by reference, and with all looks in this function: both stay in registers.
  Look lo = look(0), hi = lo;
  if (lo.way.slope == 0) return take_best();
  if (lo.way.slope > 0) {
    hi = look(kSampleStep);
  } else {
    lo = look(-kSampleStep);
  }
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
    const double beside = is_lo ? lo.way.depth : hi.way.depth;
    if (found.way.depth < beside) is_lo = lo.way.depth < hi.way.depth;
    if (is_lo) {
      lo = found;
      advance = on;
      on_one_side = std::max(on_one_side, 0) + 1;
    } else {
      hi = found;
      advance = width - on;
      on_one_side = std::min(on_one_side, 0) - 1;
    }
  }
  return take_best();
}

/// All bits where a is less than b, else none: what vector registers compute without branches. No
/// zero is less than the other.
[[nodiscard]] inline std::uint64_t if_less(double a, double b) {
  return 0 - (std::bit_cast<std::uint64_t>(a - b + 0.0) >> 63);
}

/// Where around a circle the deepest points may be, by its samples.
struct RingPeaks {
  std::uint32_t at = 0;  ///< a bit for each sample beside which a look may find something inside
  int deepest = 0;       ///< sample
  bool all_inside = false;
};

/// The bits of those samples whose mask(index) has all bits.
template <class Mask>
[[nodiscard]] std::uint64_t samples_where(const Mask& mask) {
  RingBits bits;
  for (std::size_t i = 0; i < kRingSamples; ++i) bits[i] = mask(i) & kSampleBits[i];
  return joined(bits);
}
/// The bits of the samples after those.
[[nodiscard]] constexpr std::uint64_t after(std::uint64_t samples) {
  return (samples << 1 | samples >> (kRingSamples - 1)) & kAllSamples;
}

/// `depth`: at the samples. `most`: negative where all there is between a sample and the next is
/// outside. `radius`: the circle's own.
[[nodiscard]] inline RingPeaks find_peaks(const ClosedRing& depth, const RingValues& most,
                                          double radius) {
  // A kink may be that much higher than the sample beside it.
  const double gain = 0.5 * kSampleAngle * radius;
  const double highest = greatest(depth);
  using Index = std::size_t;
  const auto rising = samples_where([&](Index i) { return if_less(depth[i], depth[i + 1]); });
  const auto far = samples_where([&](Index i) { return if_less(depth[i], -gain); });
  const auto shut = samples_where([&](Index i) { return if_less(most[i], 0); });
  const auto lower = samples_where([&](Index i) { return if_less(depth[i], highest); });
  const auto inside = samples_where([&](Index i) { return if_less(0, depth[i]); });
  const std::uint64_t before_it = lower & (kAllSamples >> 1),
                      deepest = ~before_it & (before_it + 1);
  const std::uint64_t peaks = ((after(rising) & ~rising) | deepest) & ~far & ~(shut & after(shut));
  return {static_cast<std::uint32_t>(peaks), std::countr_zero(deepest), inside == kAllSamples};
}

inline constexpr int kMostMaxima = 4;

/// Leaves out peaks that nobody uses. `used`: negative where that is so of all there is between a
/// sample and the next. Where there are more than count, unused ones may take the place of others.
inline void keep_used(const RingValues& used, RingPeaks& peaks) {
  const auto unused = samples_where([&](std::size_t i) { return if_less(used[i], 0); });
  if (peaks.all_inside) {
    peaks.all_inside = unused != kAllSamples;
    if (!peaks.all_inside) peaks.at = 0;
  } else if (std::popcount(peaks.at) <= kMostMaxima) {
    peaks.at &= ~static_cast<std::uint32_t>(unused & after(unused));
  }
}

/// Calls emit(RingMaximum) at the refined local maxima that are positive, four at most, from the
/// deepest sample on; when all of the circle is inside, at that and the three a quarter turn apart.
/// `radius`: the circle's own.
template <class F, class Emit>
void ring_maxima(const RingPeaks& peaks, const CircleBasis& circle, double radius, const F& way_at,
                 const Emit& emit) {
  RingMaximum found;
  if (peaks.all_inside) {
    if (refine_maximum(circle, peaks.deepest, radius, way_at, found)) emit(found);
    for (int k = 1; k < 4; ++k) {
      const CirclePoint at =
          circle.from_sample((peaks.deepest + k * kRingSamples / 4) % kRingSamples).at(0);
      emit(RingMaximum{at, way_at(at)});
    }
    return;
  }
  int emitted = 0;
  const std::uint32_t below = (std::uint32_t{1} << peaks.deepest) - 1;
  for (std::uint32_t rest : {peaks.at & ~below, peaks.at & below}) {
    for (; rest != 0 && emitted < kMostMaxima; rest &= rest - 1) {
      if (!refine_maximum(circle, std::countr_zero(rest), radius, way_at, found)) continue;
      emit(found);
      ++emitted;
    }
  }
}

/// Calls emit(point) where a value changes its sign between neighbouring samples, four times at
/// most. `v`: at the samples; sloped_at(point) has it and its slope by the step. Newton's method,
/// kept between the samples by halves. Where matters(i) is false, nobody asks what is between
/// sample i and the next: it counts, and is not emitted.
template <class Matters, class F, class Emit>
void ring_crossings(const RingValues& v, const CircleBasis& circle, const Matters& matters,
                    const F& sloped_at, const Emit& emit) {
  constexpr double kSame = 1e-11;
  constexpr int kMost = 40;
  const auto positive = samples_where([&](std::size_t i) { return if_less(0, v[i]); });
  const std::uint64_t next = positive >> 1 | (positive & 1) << (kRingSamples - 1);
  int most = 4;
  for (std::uint64_t rest = positive ^ next; rest != 0 && most > 0; rest &= rest - 1, --most) {
    const int i = std::countr_zero(rest);
    if (!matters(i)) continue;
    const double first = at_sample(v, i), last = at_sample(v, i + 1);
    double lo = 0, hi = kSampleStep, step = kSampleStep * first / (first - last);
    const Arc arc = circle.from_sample(i);
    CirclePoint point = arc.at(step);
    for (int pass = 0; pass < kMost; ++pass) {
      const auto [value, slope] = sloped_at(point);
      ((value > 0) == (first > 0) ? lo : hi) = step;
      double wanted = step - value / slope;
      if (!(wanted > lo && wanted < hi)) wanted = 0.5 * (lo + hi);
      const double moved = std::abs(wanted - step);
      step = wanted;
      point = arc.at(step);
      if (moved < kSame) break;
    }
    emit(point.p);
  }
}

}  // namespace aprsim::physics::detail
