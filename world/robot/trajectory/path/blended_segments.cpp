#include "world/robot/trajectory/path/blended_segments.hpp"

#include <algorithm>

// Linear segments with blends at the via points: Siciliano et al. 2009, sec. 4.2.2, where they are
// parabolic; here the speed changes by a cubic smoothstep, for continuous acceleration.

namespace aprsim::robot {
namespace {

constexpr double kBlendSteps = 8;
constexpr double kSegmentSteps = 8, kOnlySegmentSteps = 32;
constexpr double kSame = 1e-12;  ///< of the segment's duration

/// Integral of the smoothstep 3 x^2 - 2 x^3 from 0 to x, for x in 0..1, and its derivatives.
double ramp(double x) { return x * x * x * (1 - x / 2); }
double ramp_rate(double x) { return x * x * (3 - 2 * x); }
double ramp_curvature(double x) { return 6 * x * (1 - x); }
double ramp_third_derivative(double x) { return 6 - 12 * x; }

}  // namespace

void BlendedSegments::add(double duration_s) { segments_.push_back({length(), duration_s, 0, 0}); }

void BlendedSegments::blend(std::size_t corner, double half_width_s) {
  segments_[corner].blend_out = segments_[corner + 1].blend_in = half_width_s;
}

double BlendedSegments::length() const {
  return segments_.empty() ? 0 : segments_.back().begin + segments_.back().duration;
}

double BlendedSegments::room(std::size_t corner) const {
  return 0.5 * std::min(segments_[corner].duration, segments_[corner + 1].duration);
}

/// In a blend of half width w the speed rises or falls over 2 w, so that the segment covers the
/// same way as without it.
double BlendedSegments::share(std::size_t segment, double s) const {
  const Segment& x = segments_[segment];
  const double t = s - x.begin;
  if (t <= -x.blend_in) return 0;
  if (t >= x.duration + x.blend_out) return 1;
  if (t < x.blend_in) {
    // The integral of the rate: 2 w / T times the integral of the smoothstep, which is 1/2 at its
    // end, gives w / T, the same as the unblended segment at t = w.
    return 2 * x.blend_in / x.duration * ramp((t + x.blend_in) / (2 * x.blend_in));
  }
  if (t > x.duration - x.blend_out) {
    const double left = (x.duration + x.blend_out - t) / (2 * x.blend_out);
    return 1 - 2 * x.blend_out / x.duration * ramp(left);
  }
  return t / x.duration;
}

double BlendedSegments::rate(std::size_t segment, double s) const {
  const Segment& x = segments_[segment];
  const double t = s - x.begin;
  if (t < -x.blend_in || t > x.duration + x.blend_out) return 0;
  if (t < x.blend_in) return ramp_rate((t + x.blend_in) / (2 * x.blend_in)) / x.duration;
  if (t > x.duration - x.blend_out) {
    return ramp_rate((x.duration + x.blend_out - t) / (2 * x.blend_out)) / x.duration;
  }
  return 1 / x.duration;
}

double BlendedSegments::curvature(std::size_t segment, double s) const {
  const Segment& x = segments_[segment];
  const double t = s - x.begin;
  if (t < -x.blend_in || t > x.duration + x.blend_out) return 0;
  if (t < x.blend_in) {
    const double width = 2 * x.blend_in;
    return ramp_curvature((t + x.blend_in) / width) / (width * x.duration);
  }
  if (t > x.duration - x.blend_out) {
    const double width = 2 * x.blend_out;
    return -ramp_curvature((x.duration + x.blend_out - t) / width) / (width * x.duration);
  }
  return 0;
}

double BlendedSegments::third_derivative(std::size_t segment, double s) const {
  const Segment& x = segments_[segment];
  const double t = s - x.begin;
  if (t < -x.blend_in || t > x.duration + x.blend_out) return 0;
  if (t < x.blend_in) {
    const double width = 2 * x.blend_in;
    return ramp_third_derivative((t + x.blend_in) / width) / (width * width * x.duration);
  }
  if (t > x.duration - x.blend_out) {
    const double width = 2 * x.blend_out;
    return ramp_third_derivative((x.duration + x.blend_out - t) / width) /
           (width * width * x.duration);
  }
  return 0;
}

/// The segment whose own time s is in.
std::size_t BlendedSegments::at(double s) const {
  const auto after = std::upper_bound(segments_.begin(), segments_.end(), s,
                                      [](double t, const Segment& x) { return t < x.begin; });
  return after == segments_.begin() ? 0 : static_cast<std::size_t>(after - segments_.begin()) - 1;
}

BlendedSegments::Range BlendedSegments::active(double s) const {
  // A blend reaches into the segment on either side of its corner.
  const std::size_t i = at(s);
  const Segment& x = segments_[i];
  Range range{i, i};
  if (i > 0 && s < x.begin + x.blend_in) range.first = i - 1;
  if (i + 1 < segments_.size() && s > x.begin + x.duration - x.blend_out) range.last = i + 1;
  return range;
}

double BlendedSegments::next_break(double s) const {
  for (std::size_t i = at(s); i < segments_.size(); ++i) {
    const Segment& x = segments_[i];
    const double beyond = s + kSame * x.duration;
    for (const double edge : {x.begin + x.blend_in, x.begin + x.duration - x.blend_out}) {
      if (edge > beyond) return edge;
    }
  }
  return length();
}

/// At an edge the step belongs to what comes after it.
double BlendedSegments::fine_step(double s) const {
  const std::size_t i = at(s);
  const Segment& x = segments_[i];
  const double t = s - x.begin;
  if (t < x.blend_in * (1 - kSame)) return 2 * x.blend_in / kBlendSteps;
  if (t >= x.duration - x.blend_out * (1 + kSame)) {
    if (x.blend_out > 0) return 2 * x.blend_out / kBlendSteps;
  }
  return x.duration / (segments_.size() == 1 ? kOnlySegmentSteps : kSegmentSteps);
}

}  // namespace aprsim::robot
