#pragma once

#include <array>
#include <cmath>

/// Finding the deepest points around a circle. Internal to contact generation.
namespace aprsim::physics::detail {

inline constexpr int kRingSamples = 24;
inline constexpr double kSampleAngle = 0.26179938779914943653855361527329;  // 2 pi / 24

struct Direction {
  double c = 1, s = 0;
};

/// Cosine and sine of the sample angles.
[[nodiscard]] const std::array<Direction, kRingSamples>& sample_directions();

/// A sample that is no candidate for a maximum.
inline constexpr double kNoDepth = -1.0;

using RingDepths = std::array<double, kRingSamples>;

/// Angle of the maximum near sample i: successive parabolas through f(angle), which must agree
/// with v at the samples. Never worse than the sample itself.
template <class F>
double refine_maximum(const RingDepths& v, int i, const F& f) {
  double h = kSampleAngle, angle = kSampleAngle * i;
  double mid = v[static_cast<std::size_t>(i)];
  double left = v[static_cast<std::size_t>((i + kRingSamples - 1) % kRingSamples)];
  double right = v[static_cast<std::size_t>((i + 1) % kRingSamples)];
  for (int pass = 0; pass < 4; ++pass) {
    if (left <= kNoDepth || right <= kNoDepth) break;
    const double curvature = left - 2 * mid + right;
    if (!(curvature < 0)) break;
    double shift = 0.5 * (left - right) / curvature;
    shift = std::fmin(0.5, std::fmax(-0.5, shift)) * h;
    if (std::abs(shift) < 1e-5) break;
    const double value = f(angle + shift);
    h *= 0.25;
    if (value > mid) {
      angle += shift;
      mid = value;
    }
    left = f(angle - h);
    right = f(angle + h);
  }
  return angle;
}

/// Calls emit(angle) at the local maxima of the positive samples, refined; when the whole circle is
/// positive, at the deepest sample and the three a quarter turn apart. Four at most.
template <class F, class Emit>
void ring_maxima(const RingDepths& v, const F& f, const Emit& emit) {
  int deepest = 0, positive = 0;
  for (int i = 0; i < kRingSamples; ++i) {
    if (v[static_cast<std::size_t>(i)] > 0) ++positive;
    if (v[static_cast<std::size_t>(i)] > v[static_cast<std::size_t>(deepest)]) deepest = i;
  }
  if (positive == 0) return;
  emit(refine_maximum(v, deepest, f));
  if (positive == kRingSamples) {
    for (int k = 1; k < 4; ++k) {
      emit(kSampleAngle * ((deepest + k * kRingSamples / 4) % kRingSamples));
    }
    return;
  }
  int emitted = 1;
  for (int k = 1; k < kRingSamples && emitted < 4; ++k) {
    const int i = (deepest + k) % kRingSamples;
    const double mid = v[static_cast<std::size_t>(i)];
    if (mid > 0 && mid > v[static_cast<std::size_t>((i + kRingSamples - 1) % kRingSamples)] &&
        mid >= v[static_cast<std::size_t>((i + 1) % kRingSamples)]) {
      emit(refine_maximum(v, i, f));
      ++emitted;
    }
  }
}

/// Calls emit(angle) where v changes sign between neighbouring samples (up to `most` times); f must
/// agree with v at the samples.
template <class F, class Emit>
void ring_crossings(const RingDepths& v, const F& f, const Emit& emit, int most = 4) {
  for (int i = 0; i < kRingSamples && most > 0; ++i) {
    double lo = v[static_cast<std::size_t>(i)];
    double hi = v[static_cast<std::size_t>((i + 1) % kRingSamples)];
    if ((lo > 0) == (hi > 0)) continue;
    double a = kSampleAngle * i, b = a + kSampleAngle;
    // Regula falsi with the Illinois halving.
    for (int pass = 0; pass < 12 && b - a > 1e-9; ++pass) {
      const double m = a + (b - a) * (lo / (lo - hi));
      const double value = f(m);
      if ((value > 0) == (lo > 0)) {
        a = m;
        lo = value;
        hi *= 0.5;
      } else {
        b = m;
        hi = value;
        lo *= 0.5;
      }
      if (std::abs(value) < 1e-12) {
        a = b = m;
      }
    }
    emit(0.5 * (a + b));
    --most;
  }
}

}  // namespace aprsim::physics::detail
