#include "world/robot/planning/waypoint_planner.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/trajectory/limits/segment_limits.hpp"

namespace aprsim::robot {
namespace {

constexpr double kDefaultTolerance_m = 5e-3, kDefaultTolerance_rad = 0.05;
/// A blend shorter than this is none: the path then stops at the waypoint. At 0.25 m/s round a
/// right angle that is a tolerance of 10 um.
constexpr double kShortestBlend_s = 2e-4;
constexpr int kFitRounds = 60;
constexpr double kSame_m = 1e-9, kSame_rad = 1e-9;  ///< waypoints that are one

tl::unexpected<Error> at_waypoint(std::size_t index, std::size_t count, Error error) {
  error.message = "waypoint " + std::to_string(index + 1) + " of " + std::to_string(count) + ": " +
                  error.message;
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace

/// Straight line of the tool to a waypoint.
struct WaypointPlanner::Line {
  ToolLine tool_line;
  double duration_s;  ///< at full speed
  std::size_t waypoint;
};

/// Straight line in joint space to a waypoint.
struct WaypointPlanner::JointSegment {
  JointVector from, to;
  double duration_s;  ///< at full speed
  std::size_t waypoint;
  double accel, hard_accel;  ///< of the path's time [1/s]
  ToolLimits tool;
};

Result<void> WaypointPlanner::plan(const api::MoveThroughTo& move, MotionPlan& out) const {
  out.clear();
  if (auto ok = move.straight ? plan_lines(move, out) : plan_joint_segments(move, out); !ok) {
    return ok;
  }
  // Each part between two stops is one path motion; the parts run one after the other.
  // All waypoints are where the tool is already; a sequence has at least one motion.
  if (out.empty()) {
    planner_.add_joint_motion(start_.q, start_, limits_.effective({}), limits_.maximum(), out);
  }
  return {};
}

/// Checks that every waypoint is in reach.
Result<std::vector<WaypointPlanner::Line>> WaypointPlanner::find_lines(
    const api::MoveThroughTo& move) const {
  std::vector<Line> lines;
  Eigen::Isometry3d X_BT = planner_.tool_pose(start_.q, start_.X_FT);
  const std::size_t count = move.waypoints.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (planner_.cancelled()) return given_up();
    const Eigen::Isometry3d X_BT_next = planner_.pose_in_base(move.waypoints[i].X_RT);
    // Reachability of the waypoints alone gives early and specific errors, before the lines are
    // traced.
    const auto posture = planner_.target_posture(X_BT_next * start_.X_FT.inverse(), start_.q);
    if (!posture) return at_waypoint(i, count, posture.error());
    const ToolLine tool_line(X_BT, X_BT_next);
    if (tool_line.length_m() < kSame_m && tool_line.angle_rad() < kSame_rad) continue;
    const double duration =
        SegmentLimits().add(tool_line.length_m(), tool_line.angle_rad(),
                            limits_.effective(move.waypoints[i].limits), limits_.maximum());
    lines.push_back({tool_line, duration, i});
    X_BT = X_BT_next;
  }
  return lines;
}

Result<void> WaypointPlanner::plan_lines(const api::MoveThroughTo& move, MotionPlan& out) const {
  const auto found = find_lines(move);
  if (!found) return tl::unexpected(found.error());
  const std::vector<Line>& lines = *found;
  JointVector q = start_.q;
  for (std::size_t i = 0; i < lines.size();) {
    PathMotion& path = out.add().as_path();
    ToolPath& tool_path = path.begin_tool_path(start_.X_FT);
    tool_path.start(lines[i].tool_line.start());
    SegmentLimits segments;
    std::vector<double> widths;
    // Up to the next waypoint that needs a stop.
    // Lines up to a stop form one path with one profile. A blend of zero width would require
    // infinite acceleration.
    for (double width = 1; i < lines.size() && width > 0; ++i) {
      const Line& line = lines[i];
      const api::Waypoint& waypoint = move.waypoints[line.waypoint];
      segments.add(line.tool_line.length_m(), line.tool_line.angle_rad(),
                   limits_.effective(waypoint.limits), limits_.maximum());
      tool_path.add_line(line.tool_line, line.duration_s, static_cast<int>(line.waypoint) + 1);
      const bool last = i + 1 == lines.size();
      width = last ? 0 : corner_width(line, lines[i + 1], waypoint.tolerance);
      // Widths are set afterwards, since a blend needs both of its lines to be in the path.
      widths.push_back(width);
    }
    for (std::size_t k = 0; k + 1 < widths.size(); ++k) tool_path.blend(k, widths[k]);
    if (auto ok = planner_.plan_path(segments.move(q, planner_.joint_limits()), path); !ok) {
      return ok;
    }
    q = path.end();
  }
  return {};
}

Result<std::vector<WaypointPlanner::JointSegment>> WaypointPlanner::find_joint_segments(
    const api::MoveThroughTo& move) const {
  std::vector<JointSegment> segments;
  const JointLimits& joint_limits = planner_.joint_limits();
  JointVector q = start_.q;
  const std::size_t count = move.waypoints.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (planner_.cancelled()) return given_up();
    const Eigen::Isometry3d X_BT = planner_.pose_in_base(move.waypoints[i].X_RT);
    const auto target = planner_.target_posture(X_BT * start_.X_FT.inverse(), q);
    if (!target) return at_waypoint(i, count, target.error());
    // Waypoints at the same posture add nothing to the path.
    const JointVector distance = (*target - q).cwiseAbs();
    if (distance.maxCoeff() < kSame_rad) continue;
    // Full speed, and the accelerations at it, with the tool's set limits and with its maximum.
    const ToolLimits tool = limits_.effective(move.waypoints[i].limits);
    JointMove set{.start = q, .target = *target, .limits = joint_limits, .maximum = joint_limits};
    JointMove hard = set;
    planner_.limit_tool_rates(set, start_.X_FT, tool, limits_.maximum());
    planner_.limit_tool_rates(hard, start_.X_FT, limits_.maximum(), limits_.maximum());
    const double duration = std::max(1 / set.progress_speed,
                                     (distance.array() / joint_limits.speed.array()).maxCoeff());
    segments.push_back({q, *target, duration, i, set.progress_accel * duration,
                        hard.progress_accel * duration, tool});
    q = *target;
  }
  return segments;
}

Result<void> WaypointPlanner::plan_joint_segments(const api::MoveThroughTo& move,
                                                  MotionPlan& out) const {
  const auto found = find_joint_segments(move);
  if (!found) return tl::unexpected(found.error());
  const std::vector<JointSegment>& segments = *found;
  for (std::size_t i = 0; i < segments.size();) {
    PathMotion& path = out.add().as_path();
    JointPath& joint_path = path.begin_joint_path(start_.X_FT);
    const JointVector q = segments[i].from;
    joint_path.start(q);
    SegmentLimits path_limits;
    std::vector<double> widths;
    // Up to the next waypoint that needs a stop.
    for (double width = 1; i < segments.size() && width > 0; ++i) {
      const JointSegment& segment = segments[i];
      joint_path.add(segment.to, segment.duration_s);
      path_limits.add(segment.accel, segment.hard_accel, segment.tool);
      const bool last = i + 1 == segments.size();
      width =
          last ? 0
               : corner_width(segment, segments[i + 1], move.waypoints[segment.waypoint].tolerance);
      widths.push_back(width);
    }
    for (std::size_t k = 0; k + 1 < widths.size(); ++k) joint_path.blend(k, widths[k]);
    if (auto ok = planner_.plan_path(path_limits.move(q, planner_.joint_limits()), path); !ok) {
      return ok;
    }
  }
  return {};
}

double WaypointPlanner::corner_width(const Line& line, const Line& next,
                                     const api::PoseTolerance& tolerance) const {
  // A path of the two lines alone has the same corner, and is cheap to evaluate for every trial
  // width.
  ToolPath corner;
  corner.start(line.tool_line.start());
  corner.add_line(line.tool_line, line.duration_s);
  corner.add_line(next.tool_line, next.duration_s);
  return fit_blend(corner.segments().room(0), line.tool_line.end(), tolerance,
                   [&](double half_width) {
                     corner.blend(0, half_width);
                     return corner.at(line.duration_s);
                   });
}

double WaypointPlanner::corner_width(const JointSegment& segment, const JointSegment& next,
                                     const api::PoseTolerance& tolerance) const {
  JointPath corner;
  corner.start(segment.from);
  corner.add(segment.to, segment.duration_s);
  corner.add(next.to, next.duration_s);
  const Eigen::Isometry3d X_BT_goal = planner_.tool_pose(segment.to, start_.X_FT);
  return fit_blend(corner.segments().room(0), X_BT_goal, tolerance, [&](double half_width) {
    corner.blend(0, half_width);
    return planner_.tool_pose(corner.at(segment.duration_s), start_.X_FT);
  });
}

/// The widest blend at a corner that passes `X_BT_goal` within the tolerance, at most `room`;
/// `pose` gives the tool at the corner for a half width. 0 where only a stop does.
template <typename PoseAt>
double WaypointPlanner::fit_blend(double room, const Eigen::Isometry3d& X_BT_goal,
                                  const api::PoseTolerance& tolerance, const PoseAt& pose) const {
  double width = room;
  for (int i = 0; i < kFitRounds && width > kShortestBlend_s; ++i) {
    const double use = tolerance_use(pose(width), X_BT_goal, tolerance);
    if (use <= 1) return width;
    // The deviation at the corner grows with the width.
    // The deviation of a blend is proportional to its width for straight lines (Siciliano et al.
    // 2009, sec. 4.2.2). In joint space it is only nearly so, which takes a few rounds.
    width *= std::clamp(0.98 / use, 0.01, 0.95);
  }
  return 0;
}

/// The deviation of a pose in shares of its tolerance, the largest of all axes.
double WaypointPlanner::tolerance_use(const Eigen::Isometry3d& X_BT,
                                      const Eigen::Isometry3d& X_BT_goal,
                                      const api::PoseTolerance& tolerance) const {
  // CRCL gives tolerances along the axes of the robot's frame R.
  const Eigen::Vector3d off =
      planner_.X_BR().linear().transpose() * (X_BT.translation() - X_BT_goal.translation());
  const auto share = [](double value, const std::optional<double>& bound, double otherwise) {
    const double limit = bound.value_or(otherwise);
    // A tolerance of zero is met exactly on the path's own axes, and by a stop otherwise.
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

}  // namespace aprsim::robot
