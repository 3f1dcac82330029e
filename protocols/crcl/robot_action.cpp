#include "protocols/crcl/robot_action.hpp"

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

Result<api::JointTarget> to_target(const crcl::ActuateJoint& joint, crcl::AngleUnit unit,
                                   int joint_count) {
  if (joint.joint < 1 || joint.joint > joint_count) {
    return invalid("JointNumber", fmt::format("Bad joint index:{}; this robot has joints 1 to {}",
                                              joint.joint, joint_count));
  }
  const auto* details = std::get_if<crcl::JointSpeedAccel>(&joint.details);
  if (details == nullptr) {
    return fail(ErrorCode::kUnimplemented, "JointDetails",
                "ActuateJointsType with JointForceTorqueType not implemented.");
  }
  const auto speed = positive_rate(details->speed, "JointSpeed", joint.joint, unit, "s");
  if (!speed) return tl::unexpected(speed.error());
  const auto accel = positive_rate(details->accel, "JointAccel", joint.joint, unit, "s^2");
  if (!accel) return tl::unexpected(accel.error());
  return api::JointTarget{joint.joint - 1, crcl::to_si(joint.position, unit), *speed, *accel};
}

}  // namespace

Result<api::MoveTo> to_action(const crcl::MoveTo& move, const ReportSettings& units) {
  const auto axes = crcl::orthonormal_axes(move.end);
  if (!axes) return invalid("EndPosition", axes.error().message());
  const auto column = [](const crcl::Vector& v) { return Eigen::Vector3d(v.x, v.y, v.z); };
  Eigen::Matrix3d R_RT;
  R_RT << column(axes->x), column(axes->y), column(axes->z);
  const crcl::LengthUnit unit = units.units().length;
  api::MoveTo action;
  action.X_RT.p = {crcl::to_si(move.end.point.x, unit), crcl::to_si(move.end.point.y, unit),
                   crcl::to_si(move.end.point.z, unit)};
  action.X_RT.q = Eigen::Quaterniond(R_RT).normalized();
  action.straight = move.straight;
  return action;
}

Result<api::MoveJoints> to_action(const crcl::ActuateJoints& command, const ReportSettings& units,
                                  int joint_count) {
  api::MoveJoints action;
  for (const crcl::ActuateJoint& joint : command.joints) {
    Result<api::JointTarget> target = to_target(joint, units.joint_unit(), joint_count);
    if (!target) return tl::unexpected(target.error());
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
                                      const ReportSettings& units) {
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

Result<std::vector<api::SetMotionLimit>> overrides_of(const crcl::MoveTo& move,
                                                      const ReportSettings& units) {
  std::vector<api::SetMotionLimit> limits;
  if (!move.settings) return limits;
  const std::pair<crcl::RateKind, const std::optional<crcl::Rate>&> rates[] = {
      {crcl::RateKind::kTransSpeed, move.settings->trans_speed},
      {crcl::RateKind::kTransAccel, move.settings->trans_accel},
      {crcl::RateKind::kRotSpeed, move.settings->rot_speed},
      {crcl::RateKind::kRotAccel, move.settings->rot_accel},
  };
  for (const auto& [which, rate] : rates) {
    if (!rate) continue;
    const Result<api::SetMotionLimit> limit = to_action(which, *rate, units);
    if (!limit) return tl::unexpected(limit.error());
    limits.push_back(*limit);
  }
  return limits;
}

}  // namespace aprsim::protocols
