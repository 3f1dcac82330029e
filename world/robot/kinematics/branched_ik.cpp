#include "world/robot/kinematics/branched_ik.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace aprsim::robot {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kFarthestSeed_rad = 1000;
constexpr double kLimitTolerance = 1e-10;  ///< rounding at a limit; the angle is clamped to it
constexpr double kSameSolution = 1e-12;
constexpr int kElbowCandidates = 72;   ///< of the search round the circle
constexpr int kRefinements = 16;       ///< steps of the pattern search round the best candidate
constexpr int kFiner = 8;              ///< candidates of a second scan, where the first finds none
constexpr double kHopeless_m = 0.01;   ///< out of reach by more at all candidates: there is none
constexpr int kNarrowings = 24;        ///< of the search for the least violation of limits
constexpr double kLimitWeight = 0.25;  ///< of closeness to limits against distance to the seed

double degrees(double rad) { return rad * 180 / std::numbers::pi; }

std::string reach_message(double excess_m, double limit_m) {
  char text[160];
  if (limit_m == 0) {  // of arms without a shoulder and a wrist
    std::snprintf(text, sizeof text, "out of reach by %.4f m", std::abs(excess_m));
    return text;
  }
  std::snprintf(text, sizeof text, "%s by %.4f m: wrist at %.4f m from the shoulder, limit %.4f m",
                excess_m > 0 ? "out of reach" : "too close to the shoulder", std::abs(excess_m),
                limit_m + excess_m, limit_m);
  return text;
}

std::string tilt_message(double tilt_rad, int axes) {
  char text[160];
  std::snprintf(text, sizeof text,
                "tilted by %.3f deg against the poses that the arm's %d axes can reach here",
                degrees(tilt_rad), axes);
  return text;
}

std::string slide_message(const std::string& joint, double position_m, double limit_m) {
  char text[160];
  std::snprintf(text, sizeof text, "%s would be at %.3f mm, limit %.6g mm", joint.c_str(),
                position_m * 1000, limit_m * 1000);
  return text;
}

std::string limit_message(const std::string& joint, double angle_rad, double limit_rad) {
  char text[160];
  // A narrow miss must not print as the limit itself.
  const bool narrow = std::abs(degrees(angle_rad - limit_rad)) < 0.1;
  std::snprintf(text, sizeof text,
                narrow ? "%s would be at %.5f deg, limit %.6g deg"
                       : "%s would be at %.1f deg, limit %.6g deg",
                joint.c_str(), degrees(angle_rad), degrees(limit_rad));
  return text;
}

}  // namespace

BranchedIk::BranchedIk(const ArmModel& model) {
  for (const Joint& joint : model.joints) {
    ranges_.push_back({joint.name, joint.lower_rad, joint.upper_rad, joint.prismatic});
  }
}

/// Beyond the nearer limit [rad]; 0 within limits.
double BranchedIk::violation(int joint, double q) const {
  const Range& range = ranges_[static_cast<std::size_t>(joint)];
  return std::max({0.0, range.lower - q, q - range.upper});
}

double BranchedIk::relative_position(int joint, double q) const {
  const Range& range = ranges_[static_cast<std::size_t>(joint)];
  return (2 * q - range.lower - range.upper) / (range.upper - range.lower);
}

/// `angle` plus full turns: within limits the value nearest to the seed, else the value with the
/// smallest violation.
double BranchedIk::fit(int joint, double angle, double seed) const {
  const Range& range = ranges_[static_cast<std::size_t>(joint)];
  if (range.prismatic) {
    return violation(joint, angle) <= kLimitTolerance ? std::clamp(angle, range.lower, range.upper)
                                                      : angle;
  }
  // A seed far outside must not take the loops below long.
  seed = std::clamp(seed, -kFarthestSeed_rad, kFarthestSeed_rad);
  // Angles are periodic, limits are not: an axis with more than one turn has several values for one
  // posture.
  double q = angle + kTurn * std::round((seed - angle) / kTurn);
  // Full turns towards the limits while the violation falls; within limits none.
  while (q > range.upper && violation(joint, q - kTurn) < violation(joint, q)) q -= kTurn;
  while (q < range.lower && violation(joint, q + kTurn) < violation(joint, q)) q += kTurn;
  return violation(joint, q) <= kLimitTolerance ? std::clamp(q, range.lower, range.upper) : q;
}

/// The cheapest branch within limits, else the one with the smallest violation.
BranchedIk::Choice BranchedIk::choose(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                      double elbow_rad) const {
  const Branches all_branches = branches(X_BF, seed, elbow_rad);
  Choice best{.excess_m = all_branches.excess_m,
              .limit_m = all_branches.limit_m,
              .tilt_rad = all_branches.tilt_rad};
  for (int b = 0; b < all_branches.count; ++b) {
    Choice candidate{.found = true, .q = all_branches.q[static_cast<std::size_t>(b)]};
    // Full turns, largest violation, and squared distance to the seed in joint ranges.
    for (int i = 0; i < dof(); ++i) {
      const Range& range = ranges_[static_cast<std::size_t>(i)];
      const double q = fit(i, candidate.q(i), seed(i));
      const double outside = violation(i, q);
      if (outside > candidate.violation_rad) {
        candidate.found = false;
        candidate.joint = i;
        candidate.angle_rad = q;
        candidate.violation_rad = outside;
      }
      // Weighting by range makes joints comparable; a wrist turns more freely than a base axis.
      const double step = (q - seed(i)) / (range.upper - range.lower);
      candidate.cost += step * step;
      candidate.q(i) = q;
    }
    const bool better = candidate.found != best.found ? candidate.found
                        : candidate.found             ? candidate.cost < best.cost
                                          : candidate.violation_rad < best.violation_rad;
    if (b == 0 || better) best = candidate;
  }
  return best;
}

/// Out of reach, else the limit of the joint farthest beyond its own.
Error BranchedIk::refusal(const Choice& failed) const {
  if (failed.joint < 0 && failed.tilt_rad != 0) {
    return {ErrorCode::kUnreachable, "orientation", tilt_message(failed.tilt_rad, dof())};
  }
  if (failed.joint < 0) {
    return {ErrorCode::kUnreachable, "position", reach_message(failed.excess_m, failed.limit_m)};
  }
  const Range& range = ranges_[static_cast<std::size_t>(failed.joint)];
  const double limit = failed.angle_rad > range.upper ? range.upper : range.lower;
  return {ErrorCode::kUnreachable, range.name,
          range.prismatic ? slide_message(range.name, failed.angle_rad, limit)
                          : limit_message(range.name, failed.angle_rad, limit)};
}

Result<JointVector> BranchedIk::nearest(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                        double elbow_rad) const {
  if (!X_BF.matrix().allFinite() || !seed.allFinite() || !std::isfinite(elbow_rad)) {
    return fail(ErrorCode::kInvalidArgument, "pose", "the pose, seed or elbow is not a number");
  }
  const Choice choice = choose(X_BF, seed, elbow_rad);
  if (!choice.found) return tl::unexpected(refusal(choice));
  return choice.q;
}

std::vector<IkSolution> BranchedIk::all(const Eigen::Isometry3d& X_BF, double elbow_rad) const {
  std::vector<IkSolution> out;
  if (!X_BF.matrix().allFinite() || !std::isfinite(elbow_rad)) return out;
  const Branches found = branches(X_BF, JointVector::Zero(dof()), elbow_rad);
  for (int b = 0; b < found.count; ++b) {
    JointVector base = found.q[static_cast<std::size_t>(b)];
    bool within = true;
    for (int i = 0; i < dof() && within; ++i) {
      const Range& range = ranges_[static_cast<std::size_t>(i)];
      // The lowest value that the limits allow; add_turns() counts up from it.
      // Full turns are independent per joint, so that their combinations form a grid.
      if (!range.prismatic) {
        base(i) += kTurn * std::ceil((range.lower - kLimitTolerance - base(i)) / kTurn);
      }
      within = base(i) <= range.upper + kLimitTolerance &&
               (!range.prismatic || base(i) >= range.lower - kLimitTolerance);
    }
    if (within) add_turns(base, out);
  }
  return out;
}

/// All combinations of full turns within limits, counted up like an odometer.
void BranchedIk::add_turns(const JointVector& base, std::vector<IkSolution>& out) const {
  JointVector q = base;
  while (true) {
    JointVector clamped = q;
    for (int i = 0; i < dof(); ++i) {
      const Range& range = ranges_[static_cast<std::size_t>(i)];
      clamped(i) = std::clamp(q(i), range.lower, range.upper);
    }
    // Duplicates would be counted as different ways by the posture search.
    // Branches coincide at singularities (stretched arm, straight wrist).
    const bool known = std::any_of(out.begin(), out.end(), [&](const IkSolution& other) {
      return (other.q - clamped).cwiseAbs().maxCoeff() < kSameSolution;
    });
    if (!known) out.push_back({clamped});
    int i = 0;
    for (; i < dof(); ++i) {
      if (ranges_[static_cast<std::size_t>(i)].prismatic) continue;
      q(i) += kTurn;
      if (q(i) <= ranges_[static_cast<std::size_t>(i)].upper + kLimitTolerance) break;
      q(i) = base(i);
    }
    if (i == dof()) return;
  }
}

/// Distance to the seed, and closeness to limits as the eighth power of the position in the range.
double BranchedIk::posture_cost(const Choice& choice) const {
  double crowding = 0;
  for (int i = 0; i < dof(); ++i) {
    const double square = std::pow(relative_position(i, choice.q(i)), 2);
    crowding += square * square * square * square;
  }
  return choice.cost + kLimitWeight * crowding;
}

/// Ranks elbow angles without a solution: by the violation of limits, or by the missing reach.
double BranchedIk::shortfall(const Choice& choice) {
  if (choice.found) return 0;
  if (choice.joint >= 0) return choice.violation_rad;
  // Out of reach is worse than any angle.
  return kTurn + std::abs(choice.excess_m) + std::abs(choice.tilt_rad);
}

/// Golden section within `half` of `middle`; ends at the first angle with a solution.
BranchedIk::Choice BranchedIk::least_violation(const Eigen::Isometry3d& X_BF,
                                               const JointVector& seed, double middle, double half,
                                               double& elbow) const {
  constexpr double kSection = 0.6180339887498949;
  double low = middle - half, high = middle + half;
  double inner[2] = {high - kSection * (high - low), low + kSection * (high - low)};
  Choice at[2] = {choose(X_BF, seed, inner[0]), choose(X_BF, seed, inner[1])};
  for (int i = 0; i < kNarrowings && !at[0].found && !at[1].found; ++i) {
    if (shortfall(at[0]) <= shortfall(at[1])) {
      high = inner[1];
      inner[1] = inner[0];
      at[1] = at[0];
      inner[0] = high - kSection * (high - low);
      at[0] = choose(X_BF, seed, inner[0]);
    } else {
      low = inner[0];
      inner[0] = inner[1];
      at[0] = at[1];
      inner[1] = low + kSection * (high - low);
      at[1] = choose(X_BF, seed, inner[1]);
    }
  }
  const int best = at[0].found || shortfall(at[0]) <= shortfall(at[1]) ? 0 : 1;
  elbow = inner[best];
  return at[best];
}

Result<double> BranchedIk::choose_elbow(const Eigen::Isometry3d& X_BF,
                                        const JointVector& seed) const {
  if (dof() > 6) return search_elbow(X_BF, seed);
  return nearest(X_BF, seed, 0).map([](const JointVector&) { return 0.0; });
}

Result<double> BranchedIk::search_elbow(const Eigen::Isometry3d& X_BF,
                                        const JointVector& seed) const {
  // The cost has several minima in the elbow angle: a scan brackets the best one before it is
  // refined.
  // The search starts at the seed's own elbow angle, so that staying is one of the candidates.
  const double start = elbow_of(seed);
  double best_elbow = start, best_cost = 0;
  bool found = false;
  Choice least_bad;
  const auto consider = [&](const Choice& choice, double elbow) {
    if (!choice.found) {
      if (shortfall(choice) < shortfall(least_bad)) least_bad = choice;
      return;
    }
    const double cost = posture_cost(choice);
    if (found && cost >= best_cost) return;
    found = true;
    best_elbow = elbow;
    best_cost = cost;
  };
  std::array<double, kElbowCandidates * kFiner> lacking{};
  const auto scan = [&](int count) {
    const double spacing = kTurn / count;
    for (int i = 0; i < count; ++i) {
      const Choice choice = choose(X_BF, seed, start + i * spacing);
      if (i == 0) least_bad = choice;
      lacking[static_cast<std::size_t>(i)] = shortfall(choice);
      consider(choice, start + i * spacing);
    }
    // The angles within limits may be a range narrower than the spacing, about a minimum.
    const auto at = [&](int i) { return lacking[static_cast<std::size_t>((i + count) % count)]; };
    for (int i = 0; i < count && !found; ++i) {
      if (at(i) >= at(i - 1) || at(i) > at(i + 1)) continue;
      double elbow = 0;
      const Choice choice = least_violation(X_BF, seed, start + i * spacing, spacing, elbow);
      consider(choice, elbow);
    }
  };
  scan(kElbowCandidates);
  // Between two angles of the scan the reach changes by less.
  const bool is_near = shortfall(least_bad) < kTurn + kHopeless_m;
  if (!found && is_near) scan(kElbowCandidates * kFiner);
  if (!found) return tl::unexpected(refusal(least_bad));

  // Refinement by a shrinking pattern search.
  double step = kTurn / kElbowCandidates / 2;
  for (int i = 0; i < kRefinements; ++i, step *= 0.7) {
    for (const double elbow : {best_elbow - step, best_elbow + step}) {
      const Choice choice = choose(X_BF, seed, elbow);
      if (!choice.found || posture_cost(choice) >= best_cost) continue;
      best_elbow = elbow;
      best_cost = posture_cost(choice);
    }
  }
  return std::remainder(best_elbow, 2 * std::numbers::pi);
}

}  // namespace aprsim::robot
