#include "world/robot/trajectory/path/ik_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "world/robot/kinematics/pose_projection.hpp"

// Path tracking in predictor-corrector form, as in numerical continuation (Allgower & Georg 1990):
// extrapolation predicts the next posture, closed-form inverse kinematics corrects it, and the step
// length follows from the prediction error. A large error means another branch: a singularity.

namespace aprsim::robot {
namespace {

/// Largest prediction error of a sample [rad]. A change of branch within one sample is larger, or
/// too small to matter to the drives.
constexpr double kPredictionError = 5e-6;
constexpr double kLongestStep = 1.0 / 32;
constexpr double kFirstStep = 1e-6;
/// Steps shorter than these end a trace. The very first ones must be short in a nearly singular
/// start, because nothing is known yet about the joints' speeds.
constexpr double kShortestStep = 1e-8;
constexpr double kShortestFirstStep = 1e-12;
constexpr std::size_t kMoreSamples = 64;  ///< a segment
constexpr std::size_t kExtrapolationPoints = 4;
/// Samples nearer than both of these to the one before are dropped after the trace.
constexpr double kCloseStep = 1e-4;
constexpr double kCloseTurn = 1e-3;  // [rad]
/// A solution this far from the interpolated samples is on another branch [rad].
constexpr double kBranchDistance = 1e-2;

/// Distance beyond the end of a trace at which the reason of a refusal is determined.
constexpr double kBeyond = 1e-5;

/// A joint's position as people read it: degrees, millimetres of a prismatic joint.
double readable(const Joint& joint, double q) {
  return q * (joint.prismatic ? 1000 : 180 / std::numbers::pi);
}
const char* unit_of(const Joint& joint) { return joint.prismatic ? "mm" : "deg"; }

}  // namespace

Result<JointVector> IkPath::solve(const ArmGeometry& arm, double u, const JointVector& seed) const {
  const Eigen::Isometry3d X_BF = tool_.at(u >= 1 ? length_ : u * length_) * X_TF_;
  // Either the elbow angle varies linearly along the path, or the posture search has given a guide.
  if (!route_.guide.empty()) return near_guide(arm, u, X_BF);
  const double elbow = route_.elbow_start_rad + u * route_.elbow_turn_rad;
  return arm.ik.nearest(X_BF, seed, elbow);
}

/// The posture nearest to the guide, within limits.
Result<JointVector> IkPath::near_guide(const ArmGeometry& arm, double u,
                                       const Eigen::Isometry3d& X_BF) const {
  constexpr double kLimitTolerance = 1e-10;  // [rad]
  JointVector q = route_.guide.at(u);
  if (!project_to_pose(arm.model, X_BF, q)) {
    return fail(ErrorCode::kUnreachable, "posture", "the arm is stretched or its axes are aligned");
  }
  for (int i = 0; i < arm.model.dof(); ++i) {
    const Joint& joint = arm.model.joints[static_cast<std::size_t>(i)];
    if (q(i) < joint.lower_rad - kLimitTolerance || q(i) > joint.upper_rad + kLimitTolerance) {
      return fail(ErrorCode::kUnreachable, joint.name, joint.name + " would pass its limit");
    }
    q(i) = std::clamp(q(i), joint.lower_rad, joint.upper_rad);
  }
  return q;
}

/// The polynomial through the last samples (Newton's divided differences), evaluated at u.
JointVector IkPath::extrapolate(double u) const {
  const std::size_t n = std::min(samples_.size(), kExtrapolationPoints);
  const PathSample* last = samples_.data() + samples_.size() - n;
  std::array<JointVector, kExtrapolationPoints> coefficient;
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

bool IkPath::seems_feasible(const ArmGeometry& arm, const Route& route) {
  constexpr int kPoints = 8;          // of each segment
  constexpr double kLargeTurn = 1.2;  // [rad] between two points
  route_ = route;
  length_ = tool_.segments().length();
  JointVector q = route.start;
  for (std::size_t segment = 0; segment < tool_.segments().size(); ++segment) {
    const double begin = tool_.segments().begin(segment),
                 duration = tool_.segments().duration(segment);
    for (int i = 1; i <= kPoints; ++i) {
      const auto next = solve(arm, (begin + i * duration / kPoints) / length_, q);
      if (!next || (*next - q).cwiseAbs().maxCoeff() > kLargeTurn) return false;
      q = *next;
    }
  }
  return true;
}

Result<void> IkPath::trace(const ArmGeometry& arm, const Route& route) {
  route_ = route;
  length_ = tool_.segments().length();
  singular_start_ = false;
  samples_.clear();
  samples_.push_back({0, route.start, {}, {}, {}});
  double u = 0;
  double step = kFirstStep;
  while (u < 1) {
    if (arm.cancelled()) return given_up();
    // Step: as long as the prediction was accurate, but never across an edge of a blend, where
    // higher derivatives of the path jump.
    const double s = u * length_;
    const double edge = tool_.segments().next_break(s) / length_;
    double next = u + std::min(step, tool_.segments().fine_step(s) / length_);
    if (next > edge - kShortestStep) next = edge;
    if (1 - next < kShortestStep) next = 1;
    // Predictor and corrector.
    const JointVector guess = extrapolate(next);
    const auto q = solve(arm, next, guess);
    const double miss = q ? (*q - guess).cwiseAbs().maxCoeff() : 1.0;
    // Rejected: a shorter step (the error of a cubic grows with its fourth power), or the end.
    if (miss > kPredictionError) {
      step = std::min(step, next - u) *
             // Step control as in ODE integrators (Hairer, Norsett & Wanner 1993, sec. II.4):
             // factor 0.8 (tolerance / error)^(1 / order).
             std::clamp(0.8 * std::sqrt(std::sqrt(kPredictionError / miss)), 0.1, 0.7);
      if (step < (samples_.size() < kExtrapolationPoints ? kShortestFirstStep : kShortestStep)) {
        if (u < kFirstStep) find_required_start(arm);
        return refusal(arm, u);
      }
      continue;
    }
    if (samples_.size() >= kMaxPathSamples + kMoreSamples * tool_.segments().size()) {
      return refusal(arm, u);
    }
    // Accepted: the next step may be longer.
    samples_.push_back({next, *q, {}, {}, {}});
    u = next;
    const double growth = miss > 0 ? 0.8 * std::sqrt(std::sqrt(kPredictionError / miss)) : 2.0;
    step = std::min(kLongestStep, step * std::clamp(growth, 0.5, 2.0));
  }
  drop_close_samples();
  differentiate();
  return {};
}

void IkPath::find_required_start(const ArmGeometry& arm) {
  // A start is singular for its branch if the pose next to it needs a finitely different posture.
  const auto ahead = solve(arm, kFirstStep, route_.start);
  if (!ahead) return;
  const auto required = solve(arm, 0, *ahead);
  if (!required || (*required - route_.start).cwiseAbs().maxCoeff() < kCloseTurn) return;
  singular_start_ = true;
  required_start_ = *required;
}

/// The last sample at or before u, or the first one.
const JointVector& IkPath::posture_before(double u) const {
  std::size_t i = samples_.size() - 1;
  while (i > 0 && samples_[i].u > u) --i;
  return samples_[i].q;
}

/// Why the trace ended at `u`: a joint that was about to pass a limit, a pose that cannot be
/// reached, or a posture that the branch cannot leave continuously.
tl::unexpected<Error> IkPath::refusal(const ArmGeometry& arm, double u) const {
  char text[320];
  const std::string place = tool_.describe_position(u * length_);
  constexpr double kNear = 1e-3;  // [rad]
  const JointVector& here = samples_.back().q;
  const JointVector& earlier = posture_before(u - 1e-3);
  for (int i = 0; i < arm.model.dof(); ++i) {
    const Joint& joint = arm.model.joints[static_cast<std::size_t>(i)];
    const bool below = here(i) < joint.lower_rad + kNear && here(i) < earlier(i);
    const bool above = here(i) > joint.upper_rad - kNear && here(i) > earlier(i);
    if (!below && !above) continue;  // not about to pass a limit
    std::snprintf(text, sizeof text, "%s would pass its limit %.1f %s at %s", joint.name.c_str(),
                  readable(joint, below ? joint.lower_rad : joint.upper_rad), unit_of(joint),
                  place.c_str());
    return fail(ErrorCode::kUnreachable, joint.name, text);
  }
  const auto beyond = solve(arm, std::min(1.0, u + kBeyond), here);
  if (!beyond) {
    return fail(ErrorCode::kUnreachable, beyond.error().field,
                beyond.error().message + " at " + place);
  }
  int index = 0;
  const double jump = (*beyond - here).cwiseAbs().maxCoeff(&index);
  const Joint& joint = arm.model.joints[static_cast<std::size_t>(index)];
  const std::string& name = joint.name;
  std::snprintf(text, sizeof text,
                "the path meets a singular posture (arm stretched or axes aligned) at %s: %s would "
                "jump by %.1f %s",
                place.c_str(), name.c_str(), readable(joint, jump), unit_of(joint));
  return fail(ErrorCode::kUnreachable, name, text);
}

/// The short first steps of a trace leave samples too close for differences.
void IkPath::drop_close_samples() {
  std::size_t kept = 0;
  for (std::size_t i = 1; i + 1 < samples_.size(); ++i) {
    const double fine = tool_.segments().fine_step(samples_[i].u * length_) / length_;
    const bool near = samples_[i].u - samples_[kept].u < std::min(kCloseStep, 0.5 * fine) &&
                      (samples_[i].q - samples_[kept].q).cwiseAbs().maxCoeff() < kCloseTurn;
    if (!near) samples_[++kept] = samples_[i];
  }
  samples_[kept + 1] = samples_.back();
  samples_.resize(kept + 2);
  samples_.shrink_to_fit();
}

/// Three-point differences on the uneven grid; at the ends extrapolated.
void IkPath::differentiate() {
  std::vector<PathSample>& samples = samples_;
  const std::size_t n = samples.size();
  if (n == 2) {
    const JointVector slope = (samples[1].q - samples[0].q) / (samples[1].u - samples[0].u);
    for (PathSample& sample : samples) {
      sample.slope = slope;
      sample.curvature = sample.third_derivative = JointVector::Zero(slope.size());
    }
    return;
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    PathSample& here = samples[i];
    const PathSample& before = samples[i - 1];
    const PathSample& after = samples[i + 1];
    const double h0 = here.u - before.u, h1 = after.u - here.u;
    const JointVector s0 = (here.q - before.q) / h0, s1 = (after.q - here.q) / h1;
    here.slope = (h1 * s0 + h0 * s1) / (h0 + h1);
    here.curvature = 2 * (s1 - s0) / (h0 + h1);
  }
  const auto extend = [](PathSample& end, const PathSample& inner) {
    end.curvature = inner.curvature;
    end.slope = inner.slope + (end.u - inner.u) * inner.curvature;
  };
  extend(samples.front(), samples[1]);
  extend(samples.back(), samples[n - 2]);
  const auto third_derivative = [&](std::size_t i, std::size_t j) {
    return JointVector((samples[j].curvature - samples[i].curvature) /
                       (samples[j].u - samples[i].u));
  };
  for (std::size_t i = 1; i + 1 < n; ++i)
    samples[i].third_derivative = third_derivative(i - 1, i + 1);
  samples[0].third_derivative = third_derivative(0, 1);
  samples[n - 1].third_derivative = third_derivative(n - 2, n - 1);
}

/// Cubic Hermite polynomial between the neighbouring samples.
JointVector IkPath::interpolate(double u) const {
  auto after = std::upper_bound(samples_.begin(), samples_.end(), u,
                                [](double x, const PathSample& sample) { return x < sample.u; });
  if (after == samples_.end()) return samples_.back().q;
  if (after == samples_.begin()) return samples_.front().q;
  const PathSample& a = *(after - 1);
  const PathSample& b = *after;
  const double h = b.u - a.u, x = (u - a.u) / h, y = 1 - x;
  return y * y * (1 + 2 * x) * a.q + x * x * (1 + 2 * y) * b.q +
         h * x * y * (y * a.slope - x * b.slope);
}

JointVector IkPath::at(const ArmGeometry& arm, double u) const {
  if (u <= 0) return samples_.front().q;
  if (u >= 1) return samples_.back().q;
  const JointVector guess = interpolate(u);
  const auto q = solve(arm, u, guess);
  if (q && (*q - guess).cwiseAbs().maxCoeff() < kBranchDistance) return *q;
  // On another branch or beyond a limit: interpolated, within the limits.
  JointVector held = guess;
  for (int i = 0; i < arm.model.dof(); ++i) {
    const Joint& joint = arm.model.joints[static_cast<std::size_t>(i)];
    held(i) = std::clamp(held(i), joint.lower_rad, joint.upper_rad);
  }
  return held;
}

}  // namespace aprsim::robot
