#include "protocols/crcl/si_conversion.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "crcl/text.hpp"
#include "crcl/value_codec.hpp"

namespace aprsim::crcl_server {
namespace {

// Far beyond any use, far within what nanoseconds can count.
constexpr double kMaxDwellS = 1e6;
constexpr std::int64_t kMaxRecheckUs = 1'000'000'000;

constexpr std::size_t kMaxLabel = 48;

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
                                            int joint, const JointMap& joints, crcl::AngleUnit unit,
                                            const char* per) {
  if (!value) return std::nullopt;
  if (*value > 0) return joints.to_rad(joint, *value, unit);
  return invalid(name, fmt::format("{} {} {}/{} of joint {}: must be above 0", name, *value,
                                   joints.unit_name(joint, unit), per, joint));
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

Result<WireTarget> to_target(const crcl::ActuateJoint& joint, const ConnectionSettings& units,
                             const JointMap& joints) {
  const int number = joint.joint;
  if (auto ok = check_joint(number, joints.count()); !ok) return tl::unexpected(ok.error());
  const crcl::AngleUnit unit = units.joint_unit();
  WireTarget target{number, joints.to_rad(number, joint.position, unit)};
  if (const auto* torque = std::get_if<crcl::JointForceTorque>(&joint.details)) {
    auto drive = to_torque(*torque, number, units.units().torque);
    if (!drive) return tl::unexpected(drive.error());
    target.torque = *drive;
    return target;
  }
  const auto* details = &std::get<crcl::JointSpeedAccel>(joint.details);
  const auto speed = positive_rate(details->speed, "JointSpeed", number, joints, unit, "s");
  if (!speed) return tl::unexpected(speed.error());
  const auto accel = positive_rate(details->accel, "JointAccel", number, joints, unit, "s^2");
  if (!accel) return tl::unexpected(accel.error());
  if (const auto full = joints.full_speed_rad_s(number)) {
    // As on NIST's server of the Motoman: percent, and no acceleration.
    if (details->speed) target.speed_rad_s = *full * std::min(*details->speed / 100, 1.0);
    return target;
  }
  target.speed_rad_s = *speed;
  target.accel_rad_s2 = *accel;
  return target;
}

Eigen::Vector3d to_point(const crcl::Vector& point, const ConnectionSettings& units) {
  const crcl::LengthUnit unit = units.units().length;
  return {crcl::to_si(point.x, unit), crcl::to_si(point.y, unit), crcl::to_si(point.z, unit)};
}

// The decoder has refused axes that give no orientation.
Pose to_pose(const crcl::Pose& pose, const ConnectionSettings& units) {
  const crcl::Axes axes = crcl::orthonormal_axes(pose).value();
  const auto column = [](const crcl::Vector& v) { return Eigen::Vector3d(v.x, v.y, v.z); };
  Eigen::Matrix3d R_RT;
  R_RT << column(axes.x), column(axes.y), column(axes.z);
  return {to_point(pose.point, units), Eigen::Quaterniond(R_RT).normalized()};
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

Result<void> check_tolerance(const std::array<std::optional<double>, 5>& values) {
  constexpr const char* kNames[] = {"XPointTolerance", "YPointTolerance", "ZPointTolerance",
                                    "XAxisTolerance", "ZAxisTolerance"};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::optional<double>& value = values[i];
    if (value && !(*value >= 0)) {
      return invalid(kNames[i], fmt::format("{} {}: must be 0 or above", kNames[i], *value));
    }
  }
  return {};
}

Result<api::Waypoint> to_waypoint(const crcl::Waypoint& point, const ConnectionSettings& units,
                                  const std::optional<api::PoseTolerance>& default_tolerance) {
  const auto limits = to_limits(point.settings, units);
  if (!limits) return tl::unexpected(limits.error());
  api::Waypoint out{to_pose(point.pose, units), *limits,
                    default_tolerance.value_or(api::PoseTolerance{})};
  if (!point.settings || !point.settings->tolerance) return out;
  const api::PoseTolerance own = in_si(*point.settings->tolerance, units.units());
  out.tolerance = own;
  const auto ok = check_tolerance({own.x_m, own.y_m, own.z_m, own.x_axis_rad, own.z_axis_rad});
  if (!ok) return tl::unexpected(ok.error());
  return out;
}

std::string label_of(const crcl::Guard& guard) {
  std::string label = guard.name.value_or("");
  if (label.empty()) label = guard.sensor_id;
  if (!guard.name && guard.sub_field) label += " " + *guard.sub_field;
  return crcl::shorten(label, kMaxLabel);
}

Result<api::Guard> to_guard(const crcl::Guard& guard, const SensorBoard& sensors,
                            const crcl::Units& units) {
  const Result<SensorSignal> signal = sensors.find(guard.sensor_id, guard.sub_field);
  if (!signal) return tl::unexpected(signal.error());
  const bool change = guard.limit == crcl::GuardLimit::kIncreaseOverLimit ||
                      guard.limit == crcl::GuardLimit::kDecreaseBeyondLimit;
  if (change && !(guard.limit_value > 0)) {
    return invalid("LimitValue", fmt::format("LimitValue {} of guard {}: must be above 0 for an "
                                             "increase or decrease",
                                             guard.limit_value, label_of(guard)));
  }
  const std::int64_t period_us =
      guard.recheck_time_us.value_or(api::kGuardRecheck / std::chrono::microseconds(1));
  if (period_us < 0 || period_us > kMaxRecheckUs) {
    return invalid("RecheckTimeMicroSeconds",
                   fmt::format("RecheckTimeMicroSeconds {} of guard {}: must be within 0 and {}",
                               period_us, label_of(guard), kMaxRecheckUs));
  }
  api::Guard out;
  out.signal = signal->signal;
  out.limit = static_cast<api::GuardLimit>(guard.limit);
  out.value = in_si(guard.limit_value, signal->quantity, units);
  out.recheck = std::chrono::microseconds(period_us);
  out.require_trigger = guard.require_trigger.value_or(false);
  out.error_on_trigger = guard.error_on_trigger.value_or(false);
  out.label = label_of(guard);
  return out;
}

struct Bounds {
  double low, high;
};

// With the value and the limit in the unit.
std::string describe(std::string_view what, double value, const Bounds& bounds,
                     std::string_view unit, bool clamped) {
  const bool below = value < bounds.low;
  return fmt::format("{} at {:.3f} {} {} limit {:.3f} {}{}", what, value, unit,
                     below ? "less than" : "greater than", below ? bounds.low : bounds.high, unit,
                     clamped ? ", moved onto it" : "");
}

void add(std::optional<std::string>& note, const std::string& sentence) {
  note = note ? *note + "; " + sentence : sentence;
}

}  // namespace

api::PoseTolerance in_si(const crcl::PoseTolerance& tolerance, const crcl::Units& units) {
  const auto convert = [](const std::optional<double>& value, auto unit) {
    return value ? std::optional<double>(crcl::to_si(*value, unit)) : std::nullopt;
  };
  return {convert(tolerance.x_point, units.length), convert(tolerance.y_point, units.length),
          convert(tolerance.z_point, units.length), convert(tolerance.x_axis, units.angle),
          convert(tolerance.z_axis, units.angle)};
}

Result<void> check(const crcl::PoseTolerance& tolerance) {
  return check_tolerance({tolerance.x_point, tolerance.y_point, tolerance.z_point, tolerance.x_axis,
                          tolerance.z_axis});
}

Result<void> check(const std::vector<crcl::JointTolerance>& tolerances) {
  for (const crcl::JointTolerance& tolerance : tolerances) {
    if (tolerance.joint < 1) {
      return invalid("JointNumber",
                     fmt::format("Bad joint index:{}; joints are counted from 1", tolerance.joint));
    }
    if (!(tolerance.tolerance >= 0)) {
      return invalid("JointPositionTolerance",
                     fmt::format("JointPositionTolerance {} of joint {}: must be 0 or above",
                                 tolerance.tolerance, tolerance.joint));
    }
  }
  return {};
}

Result<api::MoveTo> to_action(const crcl::MoveTo& move, const ConnectionSettings& units,
                              const Tolerances& tolerances) {
  const auto end = to_waypoint(move.end, units, tolerances.end);
  if (!end) return tl::unexpected(end.error());
  return api::MoveTo{end->X_RT, move.straight, end->limits, end->tolerance};
}

Result<api::MoveThroughTo> to_action(const crcl::MoveThroughTo& move,
                                     const ConnectionSettings& units,
                                     const Tolerances& tolerances) {
  api::MoveThroughTo action;
  action.straight = move.straight;
  for (const crcl::Waypoint& point : move.waypoints) {
    const bool last = &point == &move.waypoints.back();
    Result<api::Waypoint> waypoint =
        to_waypoint(point, units, last ? tolerances.end : tolerances.intermediate);
    if (!waypoint) return tl::unexpected(waypoint.error());
    action.waypoints.push_back(*waypoint);
  }
  return action;
}

Result<api::MoveScrew> to_action(const crcl::MoveScrew& screw, const ConnectionSettings& units) {
  const crcl::LengthUnit length = units.units().length;
  api::MoveScrew action;
  if (screw.start) {
    Result<api::Waypoint> start = to_waypoint(*screw.start, units, std::nullopt);
    if (!start) return tl::unexpected(start.error());
    action.start = *start;
  }
  if (screw.axis_point) action.axis_point_R = to_point(*screw.axis_point, units);
  action.free_m = crcl::to_si(screw.free_travel.value_or(0), length);
  action.screw_m = crcl::to_si(screw.screw_travel, length);
  action.turn_rad = crcl::to_si(screw.turn, units.units().angle);
  return action;
}

Result<std::vector<WireTarget>> to_targets(const crcl::ActuateJoints& command,
                                           const ConnectionSettings& units, const JointMap& joints,
                                           const Tolerances& tolerances) {
  if (auto ok = check(command.tolerances); !ok) return tl::unexpected(ok.error());
  std::vector<WireTarget> targets;
  for (const crcl::ActuateJoint& joint : command.joints) {
    Result<WireTarget> target = to_target(joint, units, joints);
    if (!target) return tl::unexpected(target.error());
    target->tolerance_rad = tolerance_of(joint.joint, tolerances.joints);
    if (const auto own = tolerance_of(joint.joint, command.tolerances)) {
      target->tolerance_rad = joints.to_rad(joint.joint, *own, units.joint_unit());
    }
    if (std::ranges::find(targets, joint.joint, &WireTarget::number) != targets.end()) {
      return invalid("JointNumber", fmt::format("Joint {} is named twice", joint.joint));
    }
    targets.push_back(*target);
  }
  return targets;
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

Result<std::vector<api::Guard>> to_guards(const std::vector<crcl::Guard>& guards,
                                          const SensorBoard& sensors, const crcl::Units& units) {
  if (guards.size() > api::kMaxGuards) {
    return invalid("Guard",
                   fmt::format("{} guards, must be at most {}", guards.size(), api::kMaxGuards));
  }
  std::vector<api::Guard> out;
  for (const crcl::Guard& guard : guards) {
    Result<api::Guard> converted = to_guard(guard, sensors, units);
    if (!converted) return tl::unexpected(converted.error());
    out.push_back(std::move(*converted));
  }
  return out;
}

GuardedCommand to_guarded_command(api::Ticket ticket, const std::vector<crcl::Guard>& guards,
                                  const SensorBoard& sensors, const crcl::Units& units) {
  GuardedCommand out{ticket, {}};
  for (const crcl::Guard& guard : guards) {
    const Result<SensorSignal> signal = sensors.find(guard.sensor_id, guard.sub_field);
    GuardedCommand::Entry& entry = out.entries.emplace_back(
        GuardedCommand::Entry{guard, signal ? signal->quantity : Quantity::kNone});
    entry.guard.limit_value = in_si(guard.limit_value, entry.quantity, units);
    entry.guard.check_count.reset();
    entry.guard.last_check_time.reset();
    entry.guard.last_check_value.reset();
  }
  return out;
}

CartesianLimits cartesian_limits(const api::RobotDescription& robot,
                                 const std::optional<Eigen::Vector3d>& min_R,
                                 const std::optional<Eigen::Vector3d>& max_R) {
  CartesianLimits limits{robot.reach_min_R, robot.reach_max_R};
  if (min_R) limits.min_R = limits.min_R.cwiseMax(*min_R);
  if (max_R) limits.max_R = limits.max_R.cwiseMin(*max_R);
  return limits;
}

Result<std::optional<std::string>> fit(Pose& X_RT, const CartesianLimits& limits, bool clamp,
                                       crcl::LengthUnit unit) {
  constexpr const char* kAxes[] = {"X", "Y", "Z"};
  std::optional<std::string> note;
  for (int i = 0; i < 3; ++i) {
    const Bounds bounds{limits.min_R[i], limits.max_R[i]};
    double& value = X_RT.p[i];
    if (value >= bounds.low && value <= bounds.high) continue;
    const auto in_unit = [unit](double si) { return crcl::from_si(si, unit); };
    const std::string sentence =
        describe(kAxes[i], in_unit(value), {in_unit(bounds.low), in_unit(bounds.high)},
                 crcl::name_of(unit), clamp);
    if (!clamp) return fail(ErrorCode::kUnreachable, kAxes[i], sentence + ": out of reach");
    add(note, sentence);
    value = std::clamp(value, bounds.low, bounds.high);
  }
  return note;
}

Result<std::optional<std::string>> fit(std::vector<WireTarget>& targets, const JointMap& joints,
                                       bool clamp, crcl::AngleUnit unit) {
  std::optional<std::string> note;
  for (WireTarget& target : targets) {
    const int number = target.number;
    if (joints.arm_joint(number) < 0 || (!clamp && !joints.own_range(number))) continue;
    const api::AngleRange range = joints.range(number);
    if (target.angle_rad >= range.lower_rad && target.angle_rad <= range.upper_rad) continue;
    const auto in_unit = [&](double rad) { return joints.from_rad(number, rad, unit); };
    const std::string sentence =
        describe(fmt::format("Joint {}", number), in_unit(target.angle_rad),
                 {in_unit(range.lower_rad), in_unit(range.upper_rad)},
                 joints.unit_name(number, unit), clamp);
    if (!clamp) return fail(ErrorCode::kUnreachable, "JointPosition", sentence);
    add(note, sentence);
    target.angle_rad = std::clamp(target.angle_rad, range.lower_rad, range.upper_rad);
  }
  return note;
}

}  // namespace aprsim::crcl_server
