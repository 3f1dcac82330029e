#include "world/robot/planning/trajectory_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

namespace aprsim::robot {
namespace {

constexpr double kStartTolerance_rad = 0.01;  ///< of MoveIt's trajectory execution

tl::unexpected<Error> bad_point(std::size_t index, const std::string& message) {
  return fail(ErrorCode::kInvalidArgument, "points",
              "point " + std::to_string(index + 1) + ": " + message);
}

Result<void> check_size(std::size_t index, const char* what, std::size_t size, std::size_t joints) {
  if (size == joints) return {};
  return bad_point(index, std::to_string(size) + " " + what + ", must be one for each of " +
                              std::to_string(joints) + " joints");
}

Result<void> check_form(std::size_t index, const api::TrajectoryPoint& point, std::size_t joints) {
  if (auto ok = check_size(index, "positions", point.position_rad.size(), joints); !ok) return ok;
  const bool has_velocity = !point.velocity_rad_s.empty();
  if (has_velocity) {
    if (auto ok = check_size(index, "velocities", point.velocity_rad_s.size(), joints); !ok) {
      return ok;
    }
  }
  if (point.acceleration_rad_s2.empty()) return {};
  if (!has_velocity) return bad_point(index, "accelerations without velocities");
  return check_size(index, "accelerations", point.acceleration_rad_s2.size(), joints);
}

JointVector in_order(const std::vector<double>& values, const std::vector<int>& order) {
  JointVector out(static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) out(order[i]) = values[i];
  return out;
}

/// Whether the robot is where a trajectory starts.
Result<void> check_start(const JointVector& start, const JointVector& here, const ArmModel& model) {
  Eigen::Index joint = 0;
  const double off = (start - here).cwiseAbs().maxCoeff(&joint);
  if (off <= kStartTolerance_rad) return {};
  char text[200];
  std::snprintf(text, sizeof text,
                "point 1: the trajectory starts with %s at %.6g rad, the robot is at %.6g rad; "
                "at most %g rad apart",
                model.joints[static_cast<std::size_t>(joint)].name.c_str(), start(joint),
                here(joint), kStartTolerance_rad);
  return fail(ErrorCode::kInvalidArgument, "points", text);
}

std::string in_seconds(SimTime time) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g s", seconds(time));
  return text;
}

}  // namespace

Result<std::vector<int>> joint_order(const ArmModel& model, const std::vector<std::string>& names) {
  std::vector<int> order(static_cast<std::size_t>(model.dof()));
  std::iota(order.begin(), order.end(), 0);
  if (names.empty()) return order;
  const auto bad = [&](const std::string& message) {
    std::string known;
    for (const Joint& joint : model.joints) known += (known.empty() ? "" : ", ") + joint.name;
    return fail(ErrorCode::kNotFound, "joint_names", message + "; the robot has: " + known);
  };
  order.clear();
  for (const std::string& name : names) {
    const auto found = std::ranges::find(model.joints, name, &Joint::name);
    if (found == model.joints.end()) return bad("no joint is called '" + name.substr(0, 64) + "'");
    const int joint = static_cast<int>(found - model.joints.begin());
    if (std::ranges::count(order, joint) > 0) return bad("joint '" + name + "' is named twice");
    order.push_back(joint);
  }
  if (order.size() == model.joints.size()) return order;
  return bad(std::to_string(order.size()) + " of " + std::to_string(model.joints.size()) +
             " joints are named");
}

Result<std::shared_ptr<const PointBlock>> read_points(
    const std::vector<api::TrajectoryPoint>& points, const std::vector<int>& order,
    const CurvePoint& from, const CurveLimits& limits) {
  if (points.empty()) return fail(ErrorCode::kInvalidArgument, "points", "no point is given");
  auto block = std::make_shared<PointBlock>();
  block->points.reserve(points.size());
  const CurvePoint* last = &from;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const api::TrajectoryPoint& point = points[i];
    if (auto ok = check_form(i, point, order.size()); !ok) return tl::unexpected(ok.error());
    CurvePoint next{point.time, in_order(point.position_rad, order),
                    in_order(point.velocity_rad_s, order),
                    in_order(point.acceleration_rad_s2, order)};
    if (i == 0 && point.time == SimTime(0) && from.time == SimTime(0)) {
      if (auto ok = check_start(next.q, from.q, limits.model); !ok) {
        return tl::unexpected(ok.error());
      }
      continue;
    }
    if (point.time <= last->time || point.time > api::kMaxTrajectoryTime) {
      return bad_point(i, "time " + in_seconds(point.time) + ", must be above " +
                              in_seconds(last->time) + " and at most " +
                              in_seconds(api::kMaxTrajectoryTime));
    }
    if (auto ok = check_curve(limits, *last, next); !ok) return tl::unexpected(ok.error());
    last = &block->points.emplace_back(std::move(next));
  }
  if (block->points.empty()) return nullptr;
  return block;
}

}  // namespace aprsim::robot
