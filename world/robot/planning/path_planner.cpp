#include <algorithm>
#include <cmath>
#include <string>

#include "world/robot/kinematics/kinematics.hpp"
#include "world/robot/planning/motion_planner.hpp"
#include "world/robot/trajectory/segment_limits.hpp"

// Motions along paths: straight lines, past waypoints, on a helix.

namespace aprsim::robot {
namespace {

constexpr double kDefaultTolerance_m = 5e-3, kDefaultTolerance_rad = 0.05;
/// A blend shorter than this is none: the path then stops at the waypoint. At 0.25 m/s round a
/// right angle that is a tolerance of 10 um.
constexpr double kShortestBlend_s = 2e-4;
constexpr int kFitRounds = 60;
constexpr double kSame_m = 1e-9, kSame_rad = 1e-9;  ///< waypoints that are one
constexpr std::size_t kMaxStarts = 24;              ///< postures to try a screw from

tl::unexpected<Error> at_waypoint(std::size_t index, std::size_t count, Error error) {
  error.message = "waypoint " + std::to_string(index + 1) + " of " + std::to_string(count) + ": " +
                  error.message;
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace

/// Largest share of its tolerance that a pose takes, 1 = just within.
double MotionPlanner::excess(const Eigen::Isometry3d& X_BT, const Eigen::Isometry3d& X_BT_goal,
                             const api::PoseTolerance& tolerance) const {
  const Eigen::Vector3d off =
      setup_.X_BR.linear().transpose() * (X_BT.translation() - X_BT_goal.translation());
  const auto share = [](double value, const std::optional<double>& bound, double otherwise) {
    const double limit = bound.value_or(otherwise);
    return std::abs(value) <= kSame_m ? 0.0 : std::abs(value) / std::max(limit, 1e-15);
  };
  const double x_turn = angle_between(X_BT.linear().col(0), X_BT_goal.linear().col(0));
  const double z_turn = angle_between(X_BT.linear().col(2), X_BT_goal.linear().col(2));
  return std::max({share(off.x(), tolerance.x_m, kDefaultTolerance_m),
                   share(off.y(), tolerance.y_m, kDefaultTolerance_m),
                   share(off.z(), tolerance.z_m, kDefaultTolerance_m),
                   share(x_turn, tolerance.x_axis_rad, kDefaultTolerance_rad),
                   share(z_turn, tolerance.z_axis_rad, kDefaultTolerance_rad)});
}

template <typename PoseAt>
double MotionPlanner::fit_blend(double room, const Eigen::Isometry3d& X_BT_goal,
                                const api::PoseTolerance& tolerance, const PoseAt& pose) const {
  double width = room;
  for (int i = 0; i < kFitRounds && width > kShortestBlend_s; ++i) {
    const double share = excess(pose(width), X_BT_goal, tolerance);
    if (share <= 1) return width;
    // What a blend cuts off grows with its width.
    width *= std::clamp(0.98 / share, 0.01, 0.95);
  }
  return 0;
}

Result<void> MotionPlanner::plan_line(const Eigen::Isometry3d& X_BT, const PlanStart& start,
                                      const ToolLimits& tool, const ToolLimits& tool_max,
                                      MotionSequence& out) const {
  PathMotion& path = out.add().as_path();
  ToolPath& tool_path = path.lay_tool_path(start.X_FT);
  const Eigen::Isometry3d X_BT_start = flange_pose(setup_.model, start.q) * start.X_FT;
  const auto along = [&](const ToolLine& way) {
    SegmentLimits share;
    tool_path.start(X_BT_start);
    tool_path.add_line(way, share.take(way.length_m(), way.angle_rad(), tool, tool_max));
    return start_path(share.move(start.q, limits_), path);
  };
  const ToolLine way(X_BT_start, X_BT);
  const Result<void> planned = along(way);
  if (planned || !way.half_turn()) return planned;
  return along(ToolLine(X_BT_start, X_BT, true)) ? Result<void>{} : planned;
}

Result<void> MotionPlanner::plan(const api::MoveThroughTo& move, const PlanStart& start,
                                 const ToolLimitSettings& limits, MotionSequence& out) const {
  out.clear();
  if (move.waypoints.empty()) {
    return fail(ErrorCode::kInvalidArgument, "waypoints", "no waypoint is given");
  }
  return move.straight ? plan_through_straight(move, start, limits, out)
                       : plan_through_free(move, start, limits, out);
}

/// Lines with rounded corners; where a tolerance leaves no room for that the path ends and another
/// one begins.
Result<void> MotionPlanner::plan_through_straight(const api::MoveThroughTo& move,
                                                  const PlanStart& start,
                                                  const ToolLimitSettings& limits,
                                                  MotionSequence& out) const {
  struct Line {
    Eigen::Isometry3d X_BT;
    double duration;
    std::size_t waypoint;
  };
  std::vector<Line> lines;
  std::vector<double> widths;
  JointVector q = start.q;
  Eigen::Isometry3d X_BT = flange_pose(setup_.model, q) * start.X_FT;
  const std::size_t count = move.waypoints.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto X_BT_next = pose_in_base(move.waypoints[i].X_RT);
    if (!X_BT_next) return at_waypoint(i, count, X_BT_next.error());
    const auto posture = free_target(*X_BT_next * start.X_FT.inverse(), start.q);
    if (!posture) return at_waypoint(i, count, posture.error());
    const ToolLine way(lines.empty() ? X_BT : lines.back().X_BT, *X_BT_next);
    if (way.length_m() < kSame_m && way.angle_rad() < kSame_rad) continue;
    const double duration =
        SegmentLimits().take(way.length_m(), way.angle_rad(),
                             limits.effective(move.waypoints[i].limits), limits.maximum());
    lines.push_back({*X_BT_next, duration, i});
  }
  for (std::size_t i = 0; i < lines.size();) {
    PathMotion& path = out.add().as_path();
    ToolPath& tool_path = path.lay_tool_path(start.X_FT);
    tool_path.start(X_BT);
    SegmentLimits share;
    for (double width = 1; i < lines.size() && width > 0; ++i) {
      const api::Waypoint& waypoint = move.waypoints[lines[i].waypoint];
      const ToolLine way(X_BT, lines[i].X_BT);
      share.take(way.length_m(), way.angle_rad(), limits.effective(waypoint.limits),
                 limits.maximum());
      tool_path.add_line(way, lines[i].duration, static_cast<int>(lines[i].waypoint) + 1);
      width = 0;
      if (i + 1 < lines.size()) {
        ToolPath corner;
        corner.start(X_BT);
        corner.add_line(way, lines[i].duration);
        corner.add_line(ToolLine(lines[i].X_BT, lines[i + 1].X_BT), lines[i + 1].duration);
        width = fit_blend(corner.chain().room(0), lines[i].X_BT, waypoint.tolerance, [&](double w) {
          corner.blend(0, w);
          return corner.at(lines[i].duration);
        });
      }
      widths.push_back(width);
      X_BT = lines[i].X_BT;
    }
    for (std::size_t k = 0; k + 1 < widths.size(); ++k) tool_path.blend(k, widths[k]);
    widths.clear();
    if (auto ok = start_path(share.move(q, limits_), path); !ok) return ok;
    q = path.end();
  }
  if (out.empty()) plan_free(q, start, limits.effective({}), out);
  return {};
}

/// The same with straight ways in joint space.
Result<void> MotionPlanner::plan_through_free(const api::MoveThroughTo& move,
                                              const PlanStart& start,
                                              const ToolLimitSettings& limits,
                                              MotionSequence& out) const {
  struct Way {
    JointVector q;
    double duration;
    std::size_t waypoint;
    double accel, hard_accel;
    ToolLimits tool;
  };
  std::vector<Way> ways;
  JointVector q = start.q;
  const std::size_t count = move.waypoints.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto X_BT = pose_in_base(move.waypoints[i].X_RT);
    if (!X_BT) return at_waypoint(i, count, X_BT.error());
    const auto target = free_target(*X_BT * start.X_FT.inverse(), q);
    if (!target) return at_waypoint(i, count, target.error());
    const ToolLimits tool = limits.effective(move.waypoints[i].limits);
    JointMove joints{.start = q, .target = *target, .limits = limits_, .maximum = limits_};
    cap_share(joints, start.X_FT, tool);
    const JointVector way = (*target - q).cwiseAbs();
    if (way.maxCoeff() < kSame_rad) continue;
    const double duration =
        std::max(1 / joints.share_speed, (way.array() / limits_.speed.array()).maxCoeff());
    JointMove hard = joints;
    cap_share(hard, start.X_FT, limits.maximum());
    ways.push_back(
        {*target, duration, i, joints.share_accel * duration, hard.share_accel * duration, tool});
    q = *target;
  }
  q = start.q;
  std::vector<double> widths;
  for (std::size_t i = 0; i < ways.size();) {
    PathMotion& path = out.add().as_path();
    JointPath& chain = path.lay_joint_path(start.X_FT);
    chain.start(q);
    SegmentLimits share;
    const JointVector leg_start = q;
    for (double width = 1; i < ways.size() && width > 0; ++i) {
      chain.add(ways[i].q, ways[i].duration);
      share.take(ways[i].accel, ways[i].hard_accel, ways[i].tool);
      width = 0;
      if (i + 1 < ways.size()) {
        JointPath corner;
        corner.start(q);
        corner.add(ways[i].q, ways[i].duration);
        corner.add(ways[i + 1].q, ways[i + 1].duration);
        const auto pose = [&](const JointVector& at) {
          return Eigen::Isometry3d(flange_pose(setup_.model, at) * start.X_FT);
        };
        width = fit_blend(corner.chain().room(0), pose(ways[i].q),
                          move.waypoints[ways[i].waypoint].tolerance, [&](double w) {
                            corner.blend(0, w);
                            return pose(corner.at(ways[i].duration));
                          });
      }
      widths.push_back(width);
      q = ways[i].q;
    }
    for (std::size_t k = 0; k + 1 < widths.size(); ++k) chain.blend(k, widths[k]);
    widths.clear();
    if (auto ok = start_path(share.move(leg_start, limits_), path); !ok) return ok;
  }
  if (out.empty()) plan_free(q, start, limits.effective({}), out);
  return {};
}

Result<void> MotionPlanner::plan(const api::MoveScrew& screw, const PlanStart& start,
                                 const ToolLimitSettings& limits, MotionSequence& out) const {
  out.clear();
  if (!screw.start) return plan_helix(screw, start, limits, out);
  const auto X_BT = pose_in_base(screw.start->X_RT);
  if (!X_BT) return tl::unexpected(X_BT.error());
  const auto nearest = free_target(*X_BT * start.X_FT.inverse(), start.q);
  if (!nearest) return tl::unexpected(nearest.error());
  const ToolLimits tool = limits.effective(screw.start->limits);
  const auto from = [&](const JointVector& posture) -> Result<void> {
    out.clear();
    plan_free(posture, start, tool, out);
    return plan_helix(screw, {posture, start.X_FT}, limits, out);
  };
  const Result<void> first = from(*nearest);
  if (first) return first;
  for (const JointVector& posture : start_postures(*X_BT, start)) {
    if (from(posture)) return {};
  }
  return first;
}

/// Postures that the screw could begin with, the nearest first: the turn of the flange decides
/// which of them have enough of their last joint left.
std::vector<JointVector> MotionPlanner::start_postures(const Eigen::Isometry3d& X_BT,
                                                       const PlanStart& start) const {
  const Eigen::Isometry3d X_BF = X_BT * start.X_FT.inverse();
  std::vector<IkSolution> all = setup_.ik->all(X_BF, setup_.ik->elbow_of(start.q));
  if (const auto elbow = setup_.ik->choose_elbow(X_BF, start.q);
      elbow && limits_.lower.size() > 6) {
    for (const IkSolution& more : setup_.ik->all(X_BF, *elbow)) all.push_back(more);
  }
  std::stable_sort(all.begin(), all.end(), [&](const IkSolution& a, const IkSolution& b) {
    return range_distance(a.q, start.q) < range_distance(b.q, start.q);
  });
  std::vector<JointVector> postures;
  for (std::size_t i = 0; i < std::min(all.size(), kMaxStarts); ++i) postures.push_back(all[i].q);
  return postures;
}

/// The free advance along the axis, then the helix.
Result<void> MotionPlanner::plan_helix(const api::MoveScrew& screw, const PlanStart& start,
                                       const ToolLimitSettings& limits, MotionSequence& out) const {
  const ToolLimits tool = limits.effective({});
  JointVector q = start.q;
  Eigen::Isometry3d X_BT = flange_pose(setup_.model, q) * start.X_FT;
  const Eigen::Vector3d axis = X_BT.linear().col(2);
  if (screw.free_m != 0) {
    X_BT.translation() += screw.free_m * axis;
    if (auto ok = plan_line(X_BT, {q, start.X_FT}, tool, limits.maximum(), out); !ok) {
      ok.error().message = "free advance of the screw: " + ok.error().message;
      return ok;
    }
    q = out.end();
  }
  ToolHelix helix{.X_BT_start = X_BT,
                  .point_B = X_BT.translation(),
                  .direction_B = axis,
                  .travel_m = screw.screw_m,
                  .turn_rad = screw.turn_rad};
  if (screw.axis_point_R) helix.point_B = setup_.X_BR * *screw.axis_point_R;
  if (screw.screw_m == 0 && screw.turn_rad == 0) {
    if (out.empty()) plan_free(q, {q, start.X_FT}, tool, out);
    return {};
  }
  PathMotion& path = out.add().as_path();
  SegmentLimits share;
  const double duration =
      share.take(helix.length_m(), std::abs(helix.turn_rad), tool, limits.maximum());
  path.lay_tool_path(start.X_FT).make_helix(helix, duration);
  return start_path(share.move(q, limits_), path);
}

}  // namespace aprsim::robot
