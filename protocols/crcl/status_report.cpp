#include "protocols/crcl/status_report.hpp"

#include <cctype>
#include <string>

namespace aprsim::protocols {
namespace {

using crcl::from_si;

crcl::Rate rate_in(const api::LimitSetting& limit, auto unit) {
  return {limit.relative, limit.relative ? limit.value : from_si(limit.value, unit)};
}

std::optional<double> in_unit(const std::optional<double>& si, auto unit) {
  if (!si) return std::nullopt;
  return from_si(*si, unit);
}

std::optional<crcl::PoseTolerance> in_units(const std::optional<crcl::PoseTolerance>& si,
                                            const crcl::Units& units) {
  if (!si) return std::nullopt;
  return crcl::PoseTolerance{in_unit(si->x_point, units.length), in_unit(si->y_point, units.length),
                             in_unit(si->z_point, units.length), in_unit(si->x_axis, units.angle),
                             in_unit(si->z_axis, units.angle)};
}

// An xs:NMTOKEN.
std::string token(std::string text) {
  for (char& c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
  }
  return text;
}

}  // namespace

std::vector<crcl::JointStatus> joint_statuses(const api::RobotSnapshot& robot, int joint_count,
                                              const ReportSettings& settings) {
  std::vector<crcl::JointStatus> statuses;
  for (int number = 1; number <= joint_count; ++number) {
    const crcl::JointReport wanted = settings.joint(number);
    if (!wanted.position && !wanted.torque && !wanted.velocity) continue;
    const api::JointSnapshot& joint = robot.joints[static_cast<std::size_t>(number - 1)];
    crcl::JointStatus& status = statuses.emplace_back();
    status.joint = number;
    if (wanted.position) status.position = from_si(joint.position_rad, settings.joint_unit());
    if (wanted.velocity) status.velocity = from_si(joint.velocity_rad_s, settings.joint_unit());
    if (wanted.torque) status.torque = from_si(joint.torque_nm, settings.units().torque);
  }
  return statuses;
}

crcl::PoseStatus pose_status(const api::RobotSnapshot& robot, const ReportSettings& settings) {
  const crcl::LengthUnit unit = settings.units().length;
  const Eigen::Vector3d& p = robot.X_RT.p;
  const Eigen::Matrix3d R_RT = robot.X_RT.q.toRotationMatrix();
  crcl::PoseStatus status;
  status.pose.point = {from_si(p.x(), unit), from_si(p.y(), unit), from_si(p.z(), unit)};
  status.pose.x_axis = {R_RT(0, 0), R_RT(1, 0), R_RT(2, 0)};
  status.pose.z_axis = {R_RT(0, 2), R_RT(1, 2), R_RT(2, 2)};
  return status;
}

crcl::GripperStatus gripper_status(const api::RobotSnapshot& robot,
                                   const api::RobotDescription& description,
                                   const ReportSettings& settings) {
  crcl::GripperStatus status;
  status.name = token(description.name) + "_gripper";
  status.holding = robot.gripper.holding;
  status.kind = crcl::ParallelGripper{from_si(robot.gripper.separation_m, settings.units().length)};
  return status;
}

crcl::SettingsStatus settings_status(const api::Snapshot& snapshot, int robot,
                                     const RobotCommander& commander,
                                     const RobotLink::Tolerances& tolerances,
                                     const ReportSettings& settings) {
  const crcl::Units& units = settings.units();
  const auto limit = [&](api::MotionLimit which) { return commander.limit(which, snapshot); };
  crcl::SettingsStatus status;
  status.angle_unit = units.angle;
  status.end_effector = snapshot.robots[static_cast<std::size_t>(robot)].gripper.setting;
  status.force_unit = units.force;
  status.intermediate_tolerance = in_units(tolerances.intermediate, units);
  status.length_unit = units.length;
  status.end_tolerance = in_units(tolerances.end, units);
  status.rot_accel = rate_in(limit(api::MotionLimit::kRotAccel), units.angle);
  status.rot_speed = rate_in(limit(api::MotionLimit::kRotSpeed), units.angle);
  status.torque_unit = units.torque;
  status.trans_accel = rate_in(limit(api::MotionLimit::kTransAccel), units.length);
  status.trans_speed = rate_in(limit(api::MotionLimit::kTransSpeed), units.length);
  for (const crcl::JointTolerance& joint : tolerances.joints) {
    status.joint_tolerances.push_back(
        {joint.joint, from_si(joint.tolerance, settings.joint_unit())});
  }
  return status;
}

}  // namespace aprsim::protocols
