#include "world/robot/planning/move_review.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "world/robot/avoidance/path_search.hpp"
#include "world/robot/trajectory/limits/segment_limits.hpp"

namespace aprsim::robot {
namespace {

/// Motions are examined as straight pieces between postures so far apart: they deviate from them by
/// some 10 um.
constexpr double kSample_s = 5e-3;
constexpr double kMostSamples = 2000;
constexpr std::size_t kPathPoints = 32;
/// Shares of the widest blends at the corners of a path, tried in this order; 0 stops there.
constexpr std::array kBlends{1.0, 0.5, 0.25, 0.1, 0.0};
constexpr PathSearchEffort kEffort{}, kEffortElsewhere{.attempts = 1, .evaluations = 15'000};
constexpr std::size_t kMostTargets = 4;

/// The postures of all motions at equal intervals of time, with the interval.
struct Sampled {
  std::vector<JointVector> postures;
  double interval_s = kSample_s;
};

Sampled sampled(const MotionPlan& motions) {
  double duration_s = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) duration_s += motions[i].duration();
  Sampled out{.interval_s = std::max(kSample_s, duration_s / kMostSamples)};
  for (std::size_t i = 0; i < motions.size(); ++i) motions[i].sample(out.interval_s, out.postures);
  return out;
}

}  // namespace

MoveReview::MoveReview(const MotionPlanner& planner, const Surroundings& around, ReviewedMove move)
    : planner_(planner), move_(std::move(move)), checker_(planner.arm().model, around) {}

Result<void> MoveReview::run(MotionPlan& motions, bool search, bool& search_wanted) {
  const Result<void> direct = check_ends(motions).and_then([&] { return check(motions); });
  if (direct || !move_.is_free) return direct;
  const JointMotion* motion = motions[0].joint();
  // A start that is blocked stays blocked.
  if (motion == nullptr || direct.error().field == "start") return direct;
  if (!search) {
    search_wanted = true;
    return {};
  }
  const JointMotion first = *motion;
  if (go_round(first, motions)) return {};
  Error error = direct.error();
  error.message = "no way round was found: " + error.message;
  return tl::unexpected<Error>(std::move(error));
}

Result<void> MoveReview::check_ends(const MotionPlan& motions) {
  const Result<void> ends = checker_.set_ends(move_.start.q, motions.end());
  if (ends) return ends;
  Sampled all = sampled(motions);
  if (std::optional<Touch> touch = checker_.touch_at_end()) {
    touch->u *= static_cast<double>(all.postures.size() - 1);
    keep_blocked(*touch, all.interval_s, std::move(all.postures));
  }
  return ends;
}

void MoveReview::keep_blocked(const Touch& touch, double interval_s,
                              std::vector<JointVector> postures) {
  if (blocked_) return;
  blocked_ = std::make_shared<const BlockedMotion>(
      BlockedMotion{.mover = touch.mover,
                    .other = touch.other,
                    .p_R = planner_.X_BR().inverse() * touch.p_B,
                    .time_s = touch.u * interval_s,
                    .interval_s = interval_s,
                    .postures = std::move(postures)});
}

Result<void> MoveReview::check(const MotionPlan& motions) {
  Sampled all = sampled(motions);
  const PostureCurve curve(std::move(all.postures));
  const auto touch = checker_.first_touch(curve);
  if (!touch) return {};
  keep_blocked(*touch, all.interval_s, curve.postures());
  const Eigen::Vector3d p_R = planner_.X_BR().inverse() * touch->p_B;
  char where[160];
  std::snprintf(where, sizeof where, " at (%.3f, %.3f, %.3f) m, %.2f s after its start", p_R.x(),
                p_R.y(), p_R.z(), touch->u * all.interval_s);
  return fail(ErrorCode::kFailedPrecondition, "planning",
              "the move is blocked: " + touch->mover + " would touch " + touch->other + where);
}

bool MoveReview::allows(const JointMotion& motion) {
  std::vector<JointVector> postures;
  motion.sample(std::max(kSample_s, motion.duration() / kMostSamples), postures);
  return checker_.is_free(PostureCurve(std::move(postures)));
}

std::shared_ptr<const std::vector<Eigen::Vector3d>> MoveReview::path(
    const MotionPlan& motions) const {
  const PostureCurve curve(sampled(motions).postures);
  auto points = std::make_shared<std::vector<Eigen::Vector3d>>();
  const Eigen::Isometry3d X_RB = planner_.X_BR().inverse();
  for (std::size_t i = 0; i < kPathPoints; ++i) {
    const double u = curve.length() * static_cast<double>(i) / (kPathPoints - 1);
    points->push_back(X_RB * planner_.tool_pose(curve.at(u), move_.start.X_FT).translation());
  }
  return points;
}

// ---- ways round

/// Postures of the same pose, the nearest first.
std::vector<JointVector> MoveReview::other_targets(const JointVector& first) const {
  std::vector<JointVector> targets{first};
  if (move_.free_pose == nullptr) return targets;
  const InverseKinematics& ik = planner_.arm().ik;
  const JointVector& start = move_.start.q;
  const Eigen::Isometry3d X_BF =
      planner_.pose_in_base(move_.free_pose->X_RT) * move_.start.X_FT.inverse();
  std::vector<JointVector> others;
  const auto add = [&](double elbow_rad) {
    for (const IkSolution& each : ik.all(X_BF, elbow_rad)) others.push_back(each.q);
  };
  add(ik.elbow_of(start));
  if (planner_.arm().model.dof() > 6) {
    if (const auto elbow = ik.choose_elbow(X_BF, start)) add(*elbow);
  }
  std::ranges::stable_sort(others, {},
                           [&](const JointVector& q) { return planner_.range_distance(q, start); });
  constexpr double kSame = 1e-6;  // of the joint ranges
  for (const JointVector& q : others) {
    if (targets.size() == kMostTargets) break;
    if (planner_.range_distance(q, first) > kSame) targets.push_back(q);
  }
  return targets;
}

Result<void> MoveReview::go_round(const JointMotion& direct, MotionPlan& motions) {
  Result<void> result = fail(ErrorCode::kFailedPrecondition, "planning", "there is no path");
  const JointMove& like = direct.move();
  bool first = true;
  for (const JointVector& target : other_targets(direct.end())) {
    if (planner_.cancelled()) return given_up();
    const PathSearchEffort& effort = std::exchange(first, false) ? kEffort : kEffortElsewhere;
    if (!checker_.set_ends(move_.start.q, target)) continue;
    PathSearch search(checker_, like.limits, planner_.arm().cancel);
    const auto postures = search.find(move_.start.q, target, effort);
    if (!postures.empty() && lead_along(postures, like, motions)) return {};
  }
  return result;
}

/// The widest blends that are free as well.
bool MoveReview::lead_along(const std::vector<JointVector>& postures, const JointMove& like,
                            MotionPlan& out) {
  for (const double blend : kBlends) {
    if (plan_along(postures, like, blend, out) && check(out)) return true;
  }
  return false;
}

bool MoveReview::plan_along(const std::vector<JointVector>& postures, const JointMove& like,
                            double blend, MotionPlan& out) const {
  out.clear();
  const bool stops = blend == 0;
  PathMotion* path = nullptr;
  JointPath* joint_path = nullptr;
  SegmentLimits limits;
  JointVector begin;
  const auto finish = [&] {
    for (std::size_t k = 0; k + 1 < joint_path->segments().size(); ++k) {
      joint_path->blend(k, blend * joint_path->segments().room(k));
    }
    return planner_.plan_path(limits.move(begin, like.limits), *path).has_value();
  };
  for (std::size_t i = 1; i < postures.size(); ++i) {
    if (path == nullptr) {
      path = &out.add().as_path();
      joint_path = &path->begin_joint_path(move_.start.X_FT);
      begin = postures[i - 1];
      joint_path->start(begin);
      limits = SegmentLimits();
    }
    // Full speed, and the accelerations at it, with the tool's set limits and with its maximum.
    JointMove set{.start = postures[i - 1],
                  .target = postures[i],
                  .limits = like.limits,
                  .maximum = like.maximum};
    JointMove hard = set;
    planner_.limit_tool_rates(set, move_.start.X_FT, move_.tool, move_.maximum);
    planner_.limit_tool_rates(hard, move_.start.X_FT, move_.maximum, move_.maximum);
    const JointVector distance = (set.target - set.start).cwiseAbs();
    const double duration =
        std::max(1 / set.progress_speed, (distance.array() / like.limits.speed.array()).maxCoeff());
    joint_path->add(postures[i], duration);
    limits.add(set.progress_accel * duration, hard.progress_accel * duration, move_.tool);
    if (!stops) continue;
    if (!finish()) return false;
    path = nullptr;
  }
  return stops || finish();
}

}  // namespace aprsim::robot
