#include "world/robot/line_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace aprsim::robot {
namespace {

/// A sample may miss its prediction by this much [rad]. A change of branch within one sample is
/// larger, or too small to matter to the drives.
constexpr double kPredictionError = 5e-6;
constexpr double kLongestStep = 1.0 / 32;
constexpr double kFirstStep = 1e-6;
/// Steps shorter than these end a trace. The very first ones must be short in a nearly singular
/// start, because nothing is known yet about the joints' speeds.
constexpr double kShortestStep = 1e-8;
constexpr double kShortestFirstStep = 1e-12;
constexpr std::size_t kPredictFrom = 4;  ///< samples
/// Samples nearer than both of these to the one before are dropped after the trace.
constexpr double kThinStep = 1e-4;
constexpr double kThinTurn = 1e-3;  // [rad]
/// A solution this far from the interpolated samples is on another branch [rad].
constexpr double kBranchDistance = 1e-2;

/// How far beyond the end of a trace its reason is looked for.
constexpr double kBeyond = 1e-5;

double degrees(double rad) { return rad * 180 / std::numbers::pi; }

}  // namespace

LinePath::LinePath(const ArmModel& model, const InverseKinematics& ik,
                   const Eigen::Isometry3d& X_FT)
    : model_(model), ik_(ik), X_TF_(X_FT.inverse()) {
  samples_.reserve(kMaxSamples + 1);
}

Result<JointVector> LinePath::solve(double u, const JointVector& seed) const {
  const double elbow = route_.elbow_start_rad + u * route_.elbow_turn_rad;
  return ik_.nearest(route_.line.at(u) * X_TF_, seed, elbow);
}

/// The polynomial through the last samples (Newton's divided differences), evaluated at u.
JointVector LinePath::predict(double u) const {
  const std::size_t n = std::min(samples_.size(), kPredictFrom);
  const Sample* last = samples_.data() + samples_.size() - n;
  std::array<JointVector, kPredictFrom> coefficient;
  for (std::size_t i = 0; i < n; ++i) coefficient[i] = last[i].q;
  for (std::size_t order = 1; order < n; ++order) {
    for (std::size_t i = n - 1; i >= order; --i) {
      coefficient[i] = (coefficient[i] - coefficient[i - 1]) / (last[i].u - last[i - order].u);
    }
  }
  JointVector q = coefficient[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) q = coefficient[i] + (u - last[i].u) * q;
  return q;
}

bool LinePath::looks_passable(const Route& route) {
  constexpr int kPoints = 8;
  constexpr double kLargeTurn = 1.2;  // [rad] between two points
  route_ = route;
  JointVector q = route.start;
  for (int i = 1; i <= kPoints; ++i) {
    const auto next = solve(static_cast<double>(i) / kPoints, q);
    if (!next || (*next - q).cwiseAbs().maxCoeff() > kLargeTurn) return false;
    q = *next;
  }
  return true;
}

Result<void> LinePath::trace(const Route& route) {
  route_ = route;
  singular_start_ = false;
  samples_.clear();
  samples_.push_back({0, route.start, {}, {}});
  double u = 0;
  double step = kFirstStep;
  while (u < 1) {
    const double next = 1 - (u + step) < kShortestStep ? 1 : u + step;
    const JointVector guess = predict(next);
    const auto q = solve(next, guess);
    const double miss = q ? (*q - guess).cwiseAbs().maxCoeff() : 1.0;
    if (miss > kPredictionError) {
      step = std::min(step, next - u) *
             std::clamp(0.8 * std::sqrt(std::sqrt(kPredictionError / miss)), 0.1, 0.7);
      if (step < (samples_.size() < kPredictFrom ? kShortestFirstStep : kShortestStep)) {
        if (u < kFirstStep) find_needed_start();
        return blocked(u);
      }
      continue;
    }
    if (samples_.size() == kMaxSamples) return blocked(u);
    samples_.push_back({next, *q, {}, {}});
    u = next;
    const double growth = miss > 0 ? 0.8 * std::sqrt(std::sqrt(kPredictionError / miss)) : 2.0;
    step = std::min(kLongestStep, step * std::clamp(growth, 0.5, 2.0));
  }
  thin();
  differentiate();
  return {};
}

void LinePath::find_needed_start() {
  const auto ahead = solve(kFirstStep, route_.start);
  if (!ahead) return;
  const auto needed = solve(0, *ahead);
  if (!needed || (*needed - route_.start).cwiseAbs().maxCoeff() < kThinTurn) return;
  singular_start_ = true;
  needed_start_ = *needed;
}

/// The last sample at or before u, or the first one.
const JointVector& LinePath::posture_before(double u) const {
  std::size_t i = samples_.size() - 1;
  while (i > 0 && samples_[i].u > u) --i;
  return samples_[i].q;
}

/// Why the trace ended at `u`: a joint that was about to pass a limit, a pose that cannot be
/// reached, or a posture that the branch cannot leave continuously.
tl::unexpected<Error> LinePath::blocked(double u) const {
  char text[240];
  const double percent = u * 100;
  constexpr double kNear = 1e-3;  // [rad]
  const JointVector& here = samples_.back().q;
  const JointVector& earlier = posture_before(u - 1e-3);
  for (int i = 0; i < model_.dof(); ++i) {
    const Joint& joint = model_.joints[static_cast<std::size_t>(i)];
    const bool below = here(i) < joint.lower_rad + kNear && here(i) < earlier(i);
    const bool above = here(i) > joint.upper_rad - kNear && here(i) > earlier(i);
    if (!below && !above) continue;
    std::snprintf(text, sizeof text,
                  "%s would pass its limit %.1f deg at %.0f %% of the straight line",
                  joint.name.c_str(), degrees(below ? joint.lower_rad : joint.upper_rad), percent);
    return fail(ErrorCode::kUnreachable, joint.name, text);
  }
  const auto beyond = solve(std::min(1.0, u + kBeyond), here);
  if (!beyond) {
    std::snprintf(text, sizeof text, " at %.0f %% of the straight line", percent);
    return fail(ErrorCode::kUnreachable, beyond.error().field, beyond.error().message + text);
  }
  int joint = 0;
  const double jump = (*beyond - here).cwiseAbs().maxCoeff(&joint);
  const std::string& name = model_.joints[static_cast<std::size_t>(joint)].name;
  std::snprintf(text, sizeof text,
                "the straight line meets a singular posture (arm stretched or axes aligned) at "
                "%.0f %%: %s would jump by %.1f deg",
                percent, name.c_str(), degrees(jump));
  return fail(ErrorCode::kUnreachable, name, text);
}

/// Drops the samples that the cautious start of a trace leaves behind: too near for differences.
void LinePath::thin() {
  std::size_t kept = 0;
  for (std::size_t i = 1; i + 1 < samples_.size(); ++i) {
    const bool near = samples_[i].u - samples_[kept].u < kThinStep &&
                      (samples_[i].q - samples_[kept].q).cwiseAbs().maxCoeff() < kThinTurn;
    if (!near) samples_[++kept] = samples_[i];
  }
  samples_[kept + 1] = samples_.back();
  samples_.resize(kept + 2);
}

/// Three-point differences.
void LinePath::differentiate() {
  const std::size_t n = samples_.size();
  if (n == 2) {
    const JointVector slope = (samples_[1].q - samples_[0].q) / (samples_[1].u - samples_[0].u);
    for (Sample& sample : samples_) {
      sample.slope = slope;
      sample.bend = JointVector::Zero(slope.size());
    }
    return;
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    Sample& here = samples_[i];
    const Sample& before = samples_[i - 1];
    const Sample& after = samples_[i + 1];
    const double h0 = here.u - before.u, h1 = after.u - here.u;
    const JointVector s0 = (here.q - before.q) / h0, s1 = (after.q - here.q) / h1;
    here.slope = (h1 * s0 + h0 * s1) / (h0 + h1);
    here.bend = 2 * (s1 - s0) / (h0 + h1);
  }
  const auto extend = [](Sample& end, const Sample& inner) {
    end.bend = inner.bend;
    end.slope = inner.slope + (end.u - inner.u) * inner.bend;
  };
  extend(samples_.front(), samples_[1]);
  extend(samples_.back(), samples_[n - 2]);
}

/// Cubic through the neighbouring samples and their slopes.
JointVector LinePath::interpolate(double u) const {
  auto after = std::upper_bound(samples_.begin(), samples_.end(), u,
                                [](double x, const Sample& sample) { return x < sample.u; });
  if (after == samples_.end()) return samples_.back().q;
  if (after == samples_.begin()) return samples_.front().q;
  const Sample& a = *(after - 1);
  const Sample& b = *after;
  const double h = b.u - a.u, x = (u - a.u) / h, y = 1 - x;
  return y * y * (1 + 2 * x) * a.q + x * x * (1 + 2 * y) * b.q +
         h * x * y * (y * a.slope - x * b.slope);
}

JointVector LinePath::at(double u) const {
  if (u <= 0) return samples_.front().q;
  if (u >= 1) return samples_.back().q;
  const JointVector guess = interpolate(u);
  const auto q = solve(u, guess);
  if (q && (*q - guess).cwiseAbs().maxCoeff() < kBranchDistance) return *q;
  JointVector held = guess;
  for (int i = 0; i < model_.dof(); ++i) {
    const Joint& joint = model_.joints[static_cast<std::size_t>(i)];
    held(i) = std::clamp(held(i), joint.lower_rad, joint.upper_rad);
  }
  return held;
}

}  // namespace aprsim::robot
