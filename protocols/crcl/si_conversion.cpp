#include "protocols/crcl/si_conversion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <spdlog/fmt/fmt.h>

#include "crcl/pose.hpp"

namespace aprsim::protocols {
namespace {

// Far beyond any use, far within what nanoseconds can count.
constexpr double kMaxDwellS = 1e6;

struct RateRow {
  api::MotionLimit limit;
  const char* name;
  bool angular;
  const char* per;
};

const RateRow& row(crcl::RateKind which) {
  static constexpr RateRow kRows[] = {
      {api::MotionLimit::kTransSpeed, "TransSpeed", false, "s"},
      {api::MotionLimit::kTransAccel, "TransAccel", false, "s^2"},
      {api::MotionLimit::kRotSpeed, "RotSpeed", true, "s"},
      {api::MotionLimit::kRotAccel, "RotAccel", true, "s^2"},
  };
  return kRows[static_cast<std::size_t>(which)];
}

tl::unexpected<Error> invalid(const char* field, std::string message) {
  return fail(ErrorCode::kInvalidArgument, field, std::move(message));
}

Result<std::optional<double>> positive_rate(const std::optional<double>& value, const char* name,
                                            int joint, crcl::AngleUnit unit, const char* per) {
  if (!value) return std::nullopt;
  if (*value > 0) return crcl::to_si(*value, unit);
  return invalid(name, fmt::format("{} {} {}/{} of joint {}: must be above 0", name, *value,
                                   crcl::name_of(unit), per, joint));
}

// A torque has a size only: its direction is that of the position.
Result<api::JointTorque> to_torque(const crcl::JointForceTorque& details, int joint,
                                   crcl::TorqueUnit unit) {
  const auto bad = [&](const char* name, double value, const char* per) {
    return invalid(name, fmt::format("{} {} {}{} of joint {}: must be above 0", name, value,
                                     crcl::name_of(unit), per, joint));
  };
  if (!details.setting) {
    return invalid("Setting", fmt::format("Setting of joint {}: missing, the torque to drive it "
                                          "with is needed",
                                          joint));
  }
  if (!(*details.setting > 0)) return bad("Setting", *details.setting, "");
  api::JointTorque torque{crcl::to_si(*details.setting, unit), {}};
  if (!details.change_rate) return torque;
  if (!(*details.change_rate > 0)) return bad("ChangeRate", *details.change_rate, "/s");
  torque.rate_nm_s = crcl::to_si(*details.change_rate, unit);
  return torque;
}

Result<void> check_joint(int number, int joint_count) {
  if (number >= 1 && number <= joint_count) return {};
  return invalid("JointNumber", fmt::format("Bad joint index:{}; this robot has joints 1 to {}",
                                            number, joint_count));
}

std::optional<double> tolerance_of(int joint, const std::vector<crcl::JointTolerance>& in) {
  for (const crcl::JointTolerance& tolerance : in) {
    if (tolerance.joint == joint) return tolerance.tolerance;
  }
  return std::nullopt;
}

Result<api::JointTarget> to_target(const crcl::ActuateJoint& joint, const ConnectionSettings& units,
                                   int joint_count) {
  if (auto ok = check_joint(joint.joint, joint_count); !ok) return tl::unexpected(ok.error());
  api::JointTarget target{joint.joint - 1, crcl::to_si(joint.position, units.joint_unit()), {}, {}};
  if (const auto* torque = std::get_if<crcl::JointForceTorque>(&joint.details)) {
    auto drive = to_torque(*torque, joint.joint, units.units().torque);
    if (!drive) return tl::unexpected(drive.error());
    target.torque = *drive;
    return target;
  }
  const crcl::AngleUnit unit = units.joint_unit();
  const auto* details = &std::get<crcl::JointSpeedAccel>(joint.details);
  const auto speed = positive_rate(details->speed, "JointSpeed", joint.joint, unit, "s");
  if (!speed) return tl::unexpected(speed.error());
  const auto accel = positive_rate(details->accel, "JointAccel", joint.joint, unit, "s^2");
  if (!accel) return tl::unexpected(accel.error());
  target.speed_rad_s = *speed;
  target.accel_rad_s2 = *accel;
  return target;
}

Eigen::Vector3d to_point(const crcl::Vector& point, const ConnectionSettings& units) {
  const crcl::LengthUnit unit = units.units().length;
  return {crcl::to_si(point.x, unit), crcl::to_si(point.y, unit), crcl::to_si(point.z, unit)};
}

Result<Pose> to_pose(const crcl::Pose& pose, const ConnectionSettings& units, const char* element) {
  const auto axes = crcl::orthonormal_axes(pose);
  if (!axes) return invalid(element, axes.error().message());
  const auto column = [](const crcl::Vector& v) { return Eigen::Vector3d(v.x, v.y, v.z); };
  Eigen::Matrix3d R_RT;
  R_RT << column(axes->x), column(axes->y), column(axes->z);
  return Pose{to_point(pose.point, units), Eigen::Quaterniond(R_RT).normalized()};
}

Result<api::PoseLimits> to_limits(const std::optional<crcl::PoseSettings>& settings,
                                  const ConnectionSettings& units) {
  api::PoseLimits limits;
  if (!settings) return limits;
  struct Row {
    crcl::RateKind which;
    const std::optional<crcl::Rate>& rate;
    std::optional<api::LimitSetting>& limit;
  };
  const Row rows[] = {
      {crcl::RateKind::kTransSpeed, settings->trans_speed, limits.trans_speed},
      {crcl::RateKind::kTransAccel, settings->trans_accel, limits.trans_accel},
      {crcl::RateKind::kRotSpeed, settings->rot_speed, limits.rot_speed},
      {crcl::RateKind::kRotAccel, settings->rot_accel, limits.rot_accel},
  };
  for (const auto& [which, rate, limit] : rows) {
    if (!rate) continue;
    const Result<api::SetMotionLimit> set = to_action(which, *rate, units);
    if (!set) return tl::unexpected(set.error());
    limit = api::LimitSetting{set->relative, set->value};
  }
  return limits;
}

Result<api::Waypoint> to_waypoint(const crcl::Waypoint& point, const ConnectionSettings& units,
                                  const std::optional<crcl::PoseTolerance>& tolerance_si,
                                  const char* element) {
  const auto X_RT = to_pose(point.pose, units, element);
  if (!X_RT) return tl::unexpected(X_RT.error());
  const auto limits = to_limits(point.settings, units);
  if (!limits) return tl::unexpected(limits.error());
  std::optional<crcl::PoseTolerance> tolerance = tolerance_si;
  if (point.settings && point.settings->tolerance) {
    tolerance = in_si(*point.settings->tolerance, units.units());
  }
  api::Waypoint out{*X_RT, *limits, {}};
  if (!tolerance) return out;
  out.tolerance = {tolerance->x_point, tolerance->y_point, tolerance->z_point, tolerance->x_axis,
                   tolerance->z_axis};
  if (auto ok = check(*tolerance); !ok) return tl::unexpected(ok.error());
  return out;
}

}  // namespace

crcl::PoseTolerance in_si(const crcl::PoseTolerance& tolerance, const crcl::Units& units) {
  const auto convert = [](const std::optional<double>& value, auto unit) {
    return value ? std::optional<double>(crcl::to_si(*value, unit)) : std::nullopt;
  };
  return {convert(tolerance.x_point, units.length), convert(tolerance.y_point, units.length),
          convert(tolerance.z_point, units.length), convert(tolerance.x_axis, units.angle),
          convert(tolerance.z_axis, units.angle)};
}

Result<void> check(const crcl::PoseTolerance& tolerance) {
  const std::pair<const char*, const std::optional<double>&> rows[] = {
      {"XPointTolerance", tolerance.x_point}, {"YPointTolerance", tolerance.y_point},
      {"ZPointTolerance", tolerance.z_point}, {"XAxisTolerance", tolerance.x_axis},
      {"ZAxisTolerance", tolerance.z_axis},
  };
  for (const auto& [name, value] : rows) {
    if (value && !(*value >= 0)) {
      return invalid(name, fmt::format("{} {}: must be 0 or above", name, *value));
    }
  }
  return {};
}

Result<void> check(const std::vector<crcl::JointTolerance>& tolerances, int joint_count) {
  for (const crcl::JointTolerance& tolerance : tolerances) {
    if (auto ok = check_joint(tolerance.joint, joint_count); !ok) return ok;
    if (!(tolerance.tolerance >= 0)) {
      return invalid("JointPositionTolerance",
                     fmt::format("JointPositionTolerance {} of joint {}: must be 0 or above",
                                 tolerance.tolerance, tolerance.joint));
    }
  }
  return {};
}

Result<api::MoveTo> to_action(const crcl::MoveTo& move, const ConnectionSettings& units,
                              const std::optional<crcl::PoseTolerance>& end_si) {
  const auto end = to_waypoint({move.end, move.settings}, units, end_si, "EndPosition");
  if (!end) return tl::unexpected(end.error());
  return api::MoveTo{end->X_RT, move.straight, end->limits, end->tolerance};
}

Result<api::MoveThroughTo> to_action(const crcl::MoveThroughTo& move,
                                     const ConnectionSettings& units,
                                     const std::optional<crcl::PoseTolerance>& intermediate_si,
                                     const std::optional<crcl::PoseTolerance>& end_si) {
  api::MoveThroughTo action;
  action.straight = move.straight;
  for (const crcl::Waypoint& point : move.waypoints) {
    const bool last = &point == &move.waypoints.back();
    Result<api::Waypoint> waypoint =
        to_waypoint(point, units, last ? end_si : intermediate_si, "Waypoint");
    if (!waypoint) return tl::unexpected(waypoint.error());
    action.waypoints.push_back(*waypoint);
  }
  return action;
}

Result<api::MoveScrew> to_action(const crcl::MoveScrew& screw, const ConnectionSettings& units) {
  const crcl::LengthUnit length = units.units().length;
  api::MoveScrew action;
  if (screw.start) {
    Result<api::Waypoint> start = to_waypoint(*screw.start, units, std::nullopt, "StartPosition");
    if (!start) return tl::unexpected(start.error());
    action.start = *start;
  }
  if (screw.axis_point) action.axis_point_R = to_point(*screw.axis_point, units);
  action.free_m = crcl::to_si(screw.free_travel.value_or(0), length);
  action.screw_m = crcl::to_si(screw.screw_travel, length);
  action.turn_rad = crcl::to_si(screw.turn, units.units().angle);
  return action;
}

Result<api::MoveJoints> to_action(const crcl::ActuateJoints& command,
                                  const ConnectionSettings& units, int joint_count,
                                  const std::vector<crcl::JointTolerance>& default_si) {
  if (auto ok = check(command.tolerances, joint_count); !ok) return tl::unexpected(ok.error());
  api::MoveJoints action;
  for (const crcl::ActuateJoint& joint : command.joints) {
    Result<api::JointTarget> target = to_target(joint, units, joint_count);
    if (!target) return tl::unexpected(target.error());
    target->tolerance_rad = tolerance_of(joint.joint, default_si);
    if (const auto own = tolerance_of(joint.joint, command.tolerances)) {
      target->tolerance_rad = crcl::to_si(*own, units.joint_unit());
    }
    action.targets.push_back(*target);
  }
  return action;
}

api::SetGripper to_action(const crcl::SetEndEffector& set) {
  return {std::clamp(set.setting, 0.0, 1.0)};
}

Result<api::Dwell> to_action(const crcl::Dwell& dwell) {
  if (dwell.seconds < 0 || dwell.seconds > kMaxDwellS) {
    return invalid("DwellTime", fmt::format("DwellTime {} s: must be within 0 and {:.0f} s",
                                            dwell.seconds, kMaxDwellS));
  }
  return api::Dwell{SimTime(std::llround(dwell.seconds * 1e9))};
}

api::StopMotion to_action(const crcl::StopMotion& stop) {
  switch (stop.condition) {
    case crcl::StopCondition::kImmediate:
      return {api::StopKind::kImmediate};
    case crcl::StopCondition::kFast:
      return {api::StopKind::kFast};
    case crcl::StopCondition::kNormal:
      break;
  }
  return {api::StopKind::kNormal};
}

Result<api::SetMotionLimit> to_action(crcl::RateKind which, const crcl::Rate& rate,
                                      const ConnectionSettings& units) {
  const RateRow& kind = row(which);
  const std::string_view unit =
      kind.angular ? crcl::name_of(units.units().angle) : crcl::name_of(units.units().length);
  if (!(rate.value > 0)) {
    if (rate.relative) {
      return invalid(kind.name,
                     fmt::format("{} fraction {}: must be above 0", kind.name, rate.value));
    }
    return invalid(kind.name, fmt::format("{} {} {}/{}: must be above 0", kind.name, rate.value,
                                          unit, kind.per));
  }
  if (rate.relative) return api::SetMotionLimit{kind.limit, true, std::min(rate.value, 1.0)};
  const double value = kind.angular ? crcl::to_si(rate.value, units.units().angle)
                                    : crcl::to_si(rate.value, units.units().length);
  return api::SetMotionLimit{kind.limit, false, value};
}

}  // namespace aprsim::protocols
