#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>

/// Deepest points around a circle: candidate samples, then one-dimensional maximisation. Internal
/// to contact generation.
namespace aprsim::physics::detail {

inline constexpr int kCircleSamples = 24;
inline constexpr double kSampleAngle = 0.26179938779914943653855361527329;  // 2 pi / 24
inline constexpr double kSampleStep = 0.26330499517482915;                  // 2 tan(pi / 24)
/// How far an arc between two samples bulges over its chord, in radii; likewise of a value along
/// the circle whose second derivative by the angle is not under -1. 1 - cos(pi / 24) and
/// (pi / 12)^2 / 8, rounded up.
inline constexpr double kSampleBulge = 0.0086;
/// Allowance of bounds for rounding [m].
inline constexpr double kBoundSlack = 1e-9;

using CircleSamples = std::array<double, kCircleSamples>;
/// The first sample's value again at the end.
using ClosedCircleSamples = std::array<double, kCircleSamples + 1>;

/// One bit per sample.
using SampleBits = std::array<std::uint64_t, kCircleSamples>;
inline constexpr SampleBits kSampleBits = [] {
  SampleBits bits{};
  for (std::size_t i = 0; i < kCircleSamples; ++i) bits[i] = std::uint64_t{1} << i;
  return bits;
}();
[[nodiscard]] constexpr std::uint64_t joined(const SampleBits& bits) {
  std::uint64_t all = 0;
  for (const std::uint64_t bit : bits) all |= bit;
  return all;
}
inline constexpr std::uint64_t kAllSamples = joined(kSampleBits);

/// Cosines and sines of the sample angles.
struct SampleDirections {
  CircleSamples c, s;
};
inline const SampleDirections kSampleDirections = [] {
  SampleDirections d;
  for (std::size_t i = 0; i < kCircleSamples; ++i) {
    d.c[i] = std::cos(kSampleAngle * static_cast<double>(i));
    d.s[i] = std::sin(kSampleAngle * static_cast<double>(i));
  }
  return d;
}();

/// A point of a circle, and its derivative by the step along it.
struct CirclePoint {
  Eigen::Vector3d p, by_step;
};

/// A circle, parametrised from one of its points.
struct Arc {
  Eigen::Vector3d c, out, on;  ///< centre, radius at that point, radius at a quarter turn
  /// `step` is twice the tangent of half the angle: a rational parametrisation without sine and
  /// cosine.
  [[nodiscard]] CirclePoint at(double step) const {
    const double quarter2 = 0.25 * step * step, scale = 1 / (1 + quarter2);
    const double cosine = (1 - quarter2) * scale, sine = step * scale;
    return {c + cosine * out + sine * on, scale * (cosine * on - sine * out)};
  }
};

/// A circle by its centre, the radius of the first sample, and the radius a quarter turn on.
struct CircleBasis {
  Eigen::Vector3d c, a1, a2;
  /// One coordinate of all samples.
  [[nodiscard]] CircleSamples samples(Eigen::Index axis) const {
    const double middle = c(axis), from = a1(axis), on = a2(axis);
    CircleSamples out;
    for (std::size_t i = 0; i < kCircleSamples; ++i) {
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

/// Penetration exit at a point of a solid: the signed distance to the nearest surface, positive
/// inside. `kind` is that surface; where it changes along the circle the depth has a kink.
struct PenetrationExit {
  double depth = 0;
  int kind = 0;
};

/// With its gradient along the circle.
struct ExitWithGradient : PenetrationExit {
  double slope = 0;       ///< derivative of the depth by the step
  double turn = 0;        ///< the same sign, but closer to linear near an axis
  bool excluded = false;  ///< outside the piece: the depth jumps at its boundary
};

[[nodiscard]] inline double max_of(const ClosedCircleSamples& v) {
  std::array<double, 4> most{v[0], v[1], v[2], v[3]};
  for (std::size_t i = 4; i < kCircleSamples; i += 4) {
    for (std::size_t k = 0; k < 4; ++k) most[k] = std::max(most[k], v[i + k]);
  }
  return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

[[nodiscard]] inline double at_sample(const CircleSamples& v, int i) {
  return v[static_cast<std::size_t>((i + kCircleSamples) % kCircleSamples)];
}

/// Upper bound of min(a, b) over an interval on which a and b are linear, from a0 to a1 and from b0
/// to b1: negative if they are never both positive, also where one falls below zero before the
/// other rises above it.
[[nodiscard]] inline double upper_bound_of_min(double a0, double a1, double b0, double b1) {
  const double order = a0 * b1 - a1 * b0;
  return std::min(std::min(std::max(a0, a1), std::max(b0, b1)),
                  std::min(std::max(std::max(a0, b1), -order), std::max(std::max(a1, b0), order)));
}

/// A point of the circle with its penetration exit.
struct CircleMaximum {
  CirclePoint at;
  ExitWithGradient exit;
};

/// Maximum of the depth between the samples beside sample i, to half a millionth of a step.
/// Iteration: secants of the slope on one surface, tangents (Kelley's cutting planes, 1960) where
/// the nearest surface changes, the boundary of an excluded part, and bisection if the others make
/// no progress. False if everything there is outside. `radius`: that of the circle, which bounds
/// the curvature of any depth.
template <class F>
[[gnu::flatten]] bool refine_maximum(const CircleBasis& circle, int i, double radius,
                                     const F& exit_at, CircleMaximum& best) {
  constexpr double kSame = 5e-7;
  constexpr int kMost = 40, kStuck = 4;
  struct Probe {
    double step = 0;
    ExitWithGradient exit;
  };
  const Arc arc = circle.from_sample(i);
  double deepest = -1e30, best_step = 0;
  const auto probe = [&](double step) {
    const Probe found{step, exit_at(arc.at(step))};
    if (found.exit.depth > deepest) {
      deepest = found.exit.depth;
      best_step = step;
    }
    return found;
  };
  const auto accept_best = [&] {
    if (!(deepest > 0)) return false;
    best.at = arc.at(best_step);
    best.exit = exit_at(best.at);
    return true;
  };
  // Both ends are set by branches, not by reference, so that they stay in registers.
  Probe lo = probe(0), hi = lo;
  if (lo.exit.slope == 0) return accept_best();
  if (lo.exit.slope > 0) {
    hi = probe(kSampleStep);
  } else {
    lo = probe(-kSampleStep);
  }
  int on_one_side = 0;  // moves of lo (positive) or of hi in a row; the last one was by:
  double advance = 0;
  for (int pass = 0; pass < kMost; ++pass) {
    const double width = hi.step - lo.step, rise = lo.exit.slope, fall = hi.exit.slope;
    if (width < kSame) break;
    const auto bend = [radius](double exit) { return 0.5 * radius * exit * exit; };
    double on = 0.5 * width;
    if (rise > 0 && fall < 0 && !(lo.exit.excluded && hi.exit.excluded)) {
      double wanted = 0, highest = 0;
      bool last = false;
      if (lo.exit.excluded) {
        wanted = -lo.exit.depth / rise;
        highest = hi.exit.depth - fall * width + bend(width);
      } else if (hi.exit.excluded) {
        wanted = width - hi.exit.depth / fall;
        highest = lo.exit.depth + rise * width + bend(width);
      } else {
        const double tangents = (hi.exit.depth - lo.exit.depth - fall * width) / (rise - fall);
        highest = lo.exit.depth + rise * tangents + bend(std::max(tangents, width - tangents));
        const bool kink = lo.exit.kind != hi.exit.kind;
        wanted = kink ? tangents : width * lo.exit.turn / (lo.exit.turn - hi.exit.turn);
        last = kink ? bend(width) < kSame * (rise - fall) : width * width < kSame;
      }
      if (highest < 0) return false;
      const double least = 0.5 * kSame, most = width - least;
      if (last) {
        probe(lo.step + std::clamp(wanted, least, most));
        break;
      }
      // If only one end of the bracket moves, a step beyond the estimate moves the other one.
      if (on_one_side > 0) {
        wanted = wanted < least ? advance : on_one_side > 1 ? 2 * wanted : wanted;
      } else if (on_one_side < 0) {
        const double back = width - wanted;
        wanted = width - (back < least ? advance : on_one_side < -1 ? 2 * back : back);
      }
      if (std::abs(on_one_side) < kStuck) on = std::clamp(wanted, least, most);
    }
    const Probe found = probe(lo.step + on);
    if (found.exit.slope == 0) break;
    bool is_lo = found.exit.slope > 0;
    // A valley between the ends: the search stays on its higher side.
    const double beside = is_lo ? lo.exit.depth : hi.exit.depth;
    if (found.exit.depth < beside) is_lo = lo.exit.depth < hi.exit.depth;
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
  return accept_best();
}

/// All bits if a < b, else none: a mask that vector registers compute without branches. -0 and 0
/// are equal.
[[nodiscard]] inline std::uint64_t less_mask(double a, double b) {
  return 0 - (std::bit_cast<std::uint64_t>(a - b + 0.0) >> 63);
}

/// Samples beside which the deepest points of a circle may be.
struct CandidateSamples {
  std::uint32_t at = 0;  ///< one bit per sample with a possible maximum beside it
  int deepest = 0;       ///< sample
  bool all_inside = false;
};

/// Bits of the samples for which mask(index) is set.
template <class Mask>
[[nodiscard]] std::uint64_t samples_where(const Mask& mask) {
  SampleBits bits;
  for (std::size_t i = 0; i < kCircleSamples; ++i) bits[i] = mask(i) & kSampleBits[i];
  return joined(bits);
}
/// Bits of the samples that follow these.
[[nodiscard]] constexpr std::uint64_t after(std::uint64_t samples) {
  return (samples << 1 | samples >> (kCircleSamples - 1)) & kAllSamples;
}

/// Candidate samples. `depth`: at the samples. `most`: an upper bound of the depth between a sample
/// and the next. `radius`: that of the circle.
[[nodiscard]] inline CandidateSamples find_candidate_samples(const ClosedCircleSamples& depth,
                                                             const CircleSamples& most,
                                                             double radius) {
  // Largest height of a kink over its neighbouring samples.
  const double gain = 0.5 * kSampleAngle * radius;
  const double highest = max_of(depth);
  using Index = std::size_t;
  const auto rising = samples_where([&](Index i) { return less_mask(depth[i], depth[i + 1]); });
  const auto far = samples_where([&](Index i) { return less_mask(depth[i], -gain); });
  const auto shut = samples_where([&](Index i) { return less_mask(most[i], 0); });
  const auto lower = samples_where([&](Index i) { return less_mask(depth[i], highest); });
  const auto inside = samples_where([&](Index i) { return less_mask(0, depth[i]); });
  const std::uint64_t before_it = lower & (kAllSamples >> 1),
                      deepest = ~before_it & (before_it + 1);
  const std::uint64_t peaks = ((after(rising) & ~rising) | deepest) & ~far & ~(shut & after(shut));
  return {static_cast<std::uint32_t>(peaks), std::countr_zero(deepest), inside == kAllSamples};
}

inline constexpr int kMaxMaxima = 4;

/// Discards candidates that the caller would ignore. `used` is negative where everything between a
/// sample and the next is ignored. Discarded ones may still displace others beyond the maximum
/// count.
inline void discard_irrelevant(const CircleSamples& used, CandidateSamples& peaks) {
  const auto unused = samples_where([&](std::size_t i) { return less_mask(used[i], 0); });
  if (peaks.all_inside) {
    peaks.all_inside = unused != kAllSamples;
    if (!peaks.all_inside) peaks.at = 0;
  } else if (std::popcount(peaks.at) <= kMaxMaxima) {
    peaks.at &= ~static_cast<std::uint32_t>(unused & after(unused));
  }
}

/// Calls emit(CircleMaximum) at the refined positive local maxima, at most four, from the deepest
/// sample on. If the whole circle is inside, the calls are for its maximum and the three points a
/// quarter turn apart. `radius`: that of the circle.
template <class F, class Emit>
void circle_extrema(const CandidateSamples& peaks, const CircleBasis& circle, double radius,
                    const F& exit_at, const Emit& emit) {
  CircleMaximum found;
  if (peaks.all_inside) {
    if (refine_maximum(circle, peaks.deepest, radius, exit_at, found)) emit(found);
    for (int k = 1; k < 4; ++k) {
      const CirclePoint at =
          circle.from_sample((peaks.deepest + k * kCircleSamples / 4) % kCircleSamples).at(0);
      emit(CircleMaximum{at, exit_at(at)});
    }
    return;
  }
  int emitted = 0;
  const std::uint32_t below = (std::uint32_t{1} << peaks.deepest) - 1;
  for (std::uint32_t rest : {peaks.at & ~below, peaks.at & below}) {
    for (; rest != 0 && emitted < kMaxMaxima; rest &= rest - 1) {
      if (!refine_maximum(circle, std::countr_zero(rest), radius, exit_at, found)) continue;
      emit(found);
      ++emitted;
    }
  }
}

/// Calls emit(point) at the roots of a value between neighbouring samples, at most four. `v`: at
/// the samples; sloped_at(point) gives the value and its derivative by the step. Newton's method,
/// safeguarded by bisection (Press et al. 2007, sec. 9.4). A root between sample i and the next
/// with matters(i) false is counted but not emitted.
template <class Matters, class F, class Emit>
void circle_crossings(const CircleSamples& v, const CircleBasis& circle, const Matters& matters,
                      const F& sloped_at, const Emit& emit) {
  constexpr double kSame = 1e-11;
  constexpr int kMost = 40;
  const auto positive = samples_where([&](std::size_t i) { return less_mask(0, v[i]); });
  const std::uint64_t next = positive >> 1 | (positive & 1) << (kCircleSamples - 1);
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
