#include "protocols/crcl/status_builder.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "protocols/crcl/significant_digits.hpp"

namespace aprsim::crcl_server {
namespace {

crcl::Rate rate_in(const api::LimitSetting& limit, auto unit) {
  return {limit.relative,
          limit.relative ? rounded(limit.value, kRatioDecimals) : reported(limit.value, unit)};
}

std::optional<double> in_unit(const std::optional<double>& si, auto unit) {
  if (!si) return std::nullopt;
  return reported(*si, unit);
}

std::optional<crcl::PoseTolerance> in_units(const std::optional<api::PoseTolerance>& si,
                                            const crcl::Units& units) {
  if (!si) return std::nullopt;
  return crcl::PoseTolerance{in_unit(si->x_m, units.length), in_unit(si->y_m, units.length),
                             in_unit(si->z_m, units.length), in_unit(si->x_axis_rad, units.angle),
                             in_unit(si->z_axis_rad, units.angle)};
}

crcl::Vector in_unit(const Eigen::Vector3d& si, auto unit) {
  return {reported(si.x(), unit), reported(si.y(), unit), reported(si.z(), unit)};
}

std::string sign(double value) { return value > 0 ? "+" : "-"; }

// The branch of the inverse kinematics that the arm is in.
std::string configuration(const api::Posture& posture, int joint_count, const JointMap& joints,
                          crcl::AngleUnit unit) {
  if (joint_count == 6) {
    return std::string(posture.shoulder > 0 ? "front" : "back") +
           (posture.elbow > 0 ? ", elbow up" : ", elbow down") +
           (posture.wrist > 0 ? ", no flip" : ", flip");
  }
  if (joint_count < 6) return posture.elbow > 0 ? "elbow +" : "elbow -";
  // The second, fourth and sixth joint of the arm.
  const auto side = [&](int arm_joint, int value) {
    const int number = joints.number_of(arm_joint);
    return fmt::format("joint {} {}", number, sign(value * joints.sign(number)));
  };
  return fmt::format("{}, {}, {}, elbow at {:.3f} {}", side(1, posture.shoulder),
                     side(3, posture.elbow), side(5, posture.wrist),
                     reported(posture.elbow_rad, unit), crcl::name_of(unit));
}

std::vector<crcl::JointLimits> joint_limits(const api::RobotDescription& robot,
                                            const JointMap& joints,
                                            const ConnectionSettings& settings) {
  std::vector<crcl::JointLimits> limits;
  for (int number = 1; number <= joints.count(); ++number) {
    if (joints.arm_joint(number) < 0) continue;
    const auto& joint = robot.joints[static_cast<std::size_t>(joints.arm_joint(number))];
    const api::AngleRange range = joints.range(number);
    const auto in_unit = [&](double rad) {
      return joints.reported(number, rad, settings.joint_unit());
    };
    limits.push_back({number, in_unit(range.lower_rad), in_unit(range.upper_rad),
                      reported(joint.max_torque_nm, settings.units().torque),
                      in_unit(joint.max_speed_rad_s)});
  }
  return limits;
}

// Only joints that the connection reports. A number that no joint has reads 0.
std::vector<crcl::JointStatus> joint_statuses(const api::RobotSnapshot& robot, int joint_count,
                                              const JointMap& joints,
                                              const ConnectionSettings& settings) {
  Eigen::VectorXd position(joint_count), velocity(joint_count);
  for (int i = 0; i < joint_count; ++i) {
    position(i) = robot.joints[static_cast<std::size_t>(i)].position_rad;
    velocity(i) = robot.joints[static_cast<std::size_t>(i)].velocity_rad_s;
  }
  const Eigen::VectorXd angles = joints.wire_angles(position), rates = joints.wire_rates(velocity);
  const crcl::AngleUnit unit = settings.joint_unit();
  std::vector<crcl::JointStatus> statuses;
  for (int number = 1; number <= joints.count(); ++number) {
    const crcl::JointReport wanted = settings.joint(number);
    if (!wanted.position && !wanted.torque && !wanted.velocity) continue;
    crcl::JointStatus& status = statuses.emplace_back();
    status.joint = number;
    if (wanted.position) status.position = joints.reported(number, angles(number - 1), unit);
    if (wanted.velocity) status.velocity = joints.reported(number, rates(number - 1), unit);
    if (!wanted.torque) continue;
    const int arm_joint = joints.arm_joint(number);
    const double torque_nm =
        arm_joint < 0
            ? 0
            : joints.sign(number) * robot.joints[static_cast<std::size_t>(arm_joint)].torque_nm;
    status.torque = reported(torque_nm, settings.units().torque);
  }
  return statuses;
}

crcl::Pose pose_in(const Pose& pose, crcl::LengthUnit unit) {
  const Eigen::Matrix3d R = pose.q.toRotationMatrix();
  const auto axis = [&R](int column) {
    const auto component = [&](int row) { return rounded(R(row, column), kRatioDecimals); };
    return crcl::Vector{component(0), component(1), component(2)};
  };
  return {in_unit(pose.p, unit), axis(0), axis(2)};
}

// Pose of the tool in the robot's frame; twist, contact wrench and the arm's branch where they are
// asked for.
crcl::PoseStatus pose_status(const api::RobotSnapshot& robot, int joint_count,
                             const JointMap& joints, const ConnectionSettings& settings) {
  const crcl::Units& units = settings.units();
  crcl::PoseStatus status;
  status.pose = pose_in(robot.X_RT, units.length);
  if (settings.reports(ExtraReport::kTwist)) {
    status.twist =
        crcl::Twist{in_unit(robot.v_RT, units.length), in_unit(robot.omega_RT, units.angle)};
  }
  if (settings.reports(ExtraReport::kWrench)) {
    status.wrench = crcl::Wrench{in_unit(robot.force_T_R, units.force),
                                 in_unit(robot.torque_T_R, units.torque)};
  }
  if (settings.reports(ExtraReport::kConfiguration)) {
    status.configuration = configuration(robot.posture, joint_count, joints, units.angle);
  }
  return status;
}

// Null if no tool of the scene is on the flange.
const api::ToolDescription* tool_of(const api::CellDescription& cell,
                                    const api::RobotSnapshot& robot) {
  const auto index = static_cast<std::size_t>(robot.tool);
  return robot.tool >= 0 && index < cell.tools.size() ? &cell.tools[index] : nullptr;
}

crcl::GripperStatus measured_gripper(const api::ToolDescription* tool,
                                     const api::GripperSnapshot& gripper,
                                     const ConnectionSettings& settings) {
  crcl::GripperStatus status;
  status.holding = gripper.holding;
  if (tool != nullptr && tool->gripper.cup_radius_m > 0) {
    status.kind = crcl::VacuumGripper{gripper.setting <= 0.5};
  } else {
    status.kind = crcl::ParallelGripper{reported(gripper.separation_m, settings.units().length)};
  }
  return status;
}

// Names the commander of a streamed motion where nothing else is described.
void describe_stream(const api::MotionSnapshot& motion, crcl::CommandStatus& command) {
  if (motion.source != api::MotionSource::kStream || command.description) return;
  command.description = fmt::format("{} has the robot by a stream of motions", motion.commander);
}

int override_percent(const api::RobotSnapshot& robot) {
  return static_cast<int>(std::lround(robot.override_fraction * 100));
}

// Status of the attached tool, with its kind, and its name if the scene lists it.
crcl::GripperStatus gripper_status(const api::CellDescription& cell,
                                   const api::RobotSnapshot& robot,
                                   const RobotParameters& parameters,
                                   const ConnectionSettings& settings) {
  const api::ToolDescription* tool = tool_of(cell, robot);
  crcl::GripperStatus status = measured_gripper(tool, robot.gripper, settings);
  status.name = tool != nullptr ? parameters.name_of(*tool) : parameters.gripper_name();
  status.options = parameters.gripper_options();
  return status;
}

std::vector<crcl::ParameterSetting> listed(const std::map<std::string, std::string>& kept) {
  std::vector<crcl::ParameterSetting> settings;
  for (const auto& [name, value] : kept) settings.push_back({name, value});
  return settings;
}

// Those whose report is not disabled.
std::vector<crcl::ParameterSetting> robot_parameters(const RobotParameters& parameters,
                                                     const api::Snapshot& snapshot,
                                                     const api::RobotSnapshot& robot) {
  std::map<std::string, std::string> all = parameters.robot();
  for (const std::string& name : parameters.shown()) {
    if (name == parameter::kSimulatedTime)
      all[name] = fmt::format("{:.3f}", seconds(snapshot.time));
    if (name == parameter::kProtectiveStop) all[name] = robot.protective_stop ? "true" : "false";
    if (name == parameter::kDrives) all[name] = robot.drives_on ? "on" : "off";
    if (name == parameter::kPlanning) all[name] = std::string(api::name_of(robot.planning));
    if (name == parameter::kSpeedOverride) {
      all[name] = fmt::format("{:g}", robot.override_fraction * 100);
    }
  }
  for (const std::string& name : parameters.hidden()) all.erase(name);
  return listed(all);
}

crcl::SettingsStatus settings_status(const StatusSources& sources,
                                     const ConnectionSettings& settings) {
  const crcl::Units& units = settings.units();
  const api::Snapshot& snapshot = sources.snapshot;
  const auto index = static_cast<std::size_t>(sources.robot);
  const Tolerances& tolerances = sources.tolerances;
  const auto limit = [&](api::MotionLimit which) {
    return sources.submitter.limit(which, snapshot);
  };
  crcl::SettingsStatus status;
  status.angle_unit = units.angle;
  status.end_effector_parameters = listed(sources.parameters.end_effector());
  status.end_effector = rounded(snapshot.robots[index].gripper.setting, kRatioDecimals);
  status.force_unit = units.force;
  status.intermediate_tolerance = in_units(tolerances.intermediate, units);
  status.length_unit = units.length;
  if (settings.reports(ExtraReport::kLimits)) {
    status.joint_limits = joint_limits(snapshot.cell->robots[index], sources.joints, settings);
    status.max_cartesian = in_unit(sources.limits.max_R, units.length);
    status.min_cartesian = in_unit(sources.limits.min_R, units.length);
  }
  status.coordinated = sources.parameters.coordinated();
  status.robot_parameters = robot_parameters(sources.parameters, snapshot, snapshot.robots[index]);
  status.end_tolerance = in_units(tolerances.end, units);
  status.rot_accel = rate_in(limit(api::MotionLimit::kRotAccel), units.angle);
  status.rot_speed = rate_in(limit(api::MotionLimit::kRotSpeed), units.angle);
  status.torque_unit = units.torque;
  status.trans_accel = rate_in(limit(api::MotionLimit::kTransAccel), units.length);
  status.trans_speed = rate_in(limit(api::MotionLimit::kTransSpeed), units.length);
  for (const crcl::JointTolerance& joint : tolerances.joints) {
    status.joint_tolerances.push_back(
        {joint.joint,
         sources.joints.reported(joint.joint, joint.tolerance, settings.joint_unit())});
  }
  return status;
}

// Guards of the latest guarded command; without readings until the world has accepted it.
crcl::GuardsStatuses guards_statuses(const GuardedCommand& command, const api::GuardsSnapshot& seen,
                                     std::int64_t start_ms, const crcl::Units& units) {
  const bool current = seen.ticket == command.ticket;
  crcl::GuardsStatuses out;
  for (std::size_t i = 0; i < command.entries.size(); ++i) {
    const Quantity quantity = command.entries[i].quantity;
    crcl::Guard& guard = out.guards.emplace_back(command.entries[i].guard);
    guard.limit_value = in_unit(guard.limit_value, quantity, units);
    if (!current || i >= seen.count || seen.guards[i].checks == 0) continue;
    guard.check_count = static_cast<std::int64_t>(seen.guards[i].checks);
    guard.last_check_time = start_ms + seen.guards[i].last_check / std::chrono::milliseconds(1);
    guard.last_check_value = in_unit(seen.guards[i].last_value, quantity, units);
  }
  out.trigger_count = static_cast<std::int32_t>(
      std::min<std::uint32_t>(seen.triggers, std::numeric_limits<std::int32_t>::max()));
  out.trigger_stop_time_us = seen.stop_time / std::chrono::microseconds(1);
  if (seen.triggers > 0) {
    const bool known = current && seen.trigger_guard < command.entries.size();
    const Quantity quantity =
        known ? command.entries[seen.trigger_guard].quantity : Quantity::kNone;
    out.trigger_value = in_unit(seen.trigger_value, quantity, units);
    out.trigger_pose = pose_in(seen.trigger_X_RT, units.length);
  }
  return out;
}

}  // namespace

crcl::Status measured_status(const api::Snapshot& snapshot, std::size_t robot,
                             const JointMap& joints, const ConnectionSettings& settings) {
  const api::RobotSnapshot& of = snapshot.robots[robot];
  const int joint_count = static_cast<int>(snapshot.cell->robots[robot].joints.size());
  crcl::Status status;
  status.command.override_percent = override_percent(of);
  status.joints = joint_statuses(of, joint_count, joints, settings);
  status.pose = pose_status(of, joint_count, joints, settings);
  if (of.tool_mounted) {
    status.gripper = measured_gripper(tool_of(*snapshot.cell, of), of.gripper, settings);
  }
  return status;
}

crcl::Status build_status(crcl::CommandStatus command, const StatusSources& sources,
                          const ConnectionSettings& settings) {
  const api::Snapshot& snapshot = sources.snapshot;
  const auto index = static_cast<std::size_t>(sources.robot);
  const api::RobotSnapshot& robot = snapshot.robots[index];
  const int joint_count = static_cast<int>(snapshot.cell->robots[index].joints.size());
  const crcl::ConfigureStatusReport& wanted = settings.sections();
  crcl::Status status;
  status.command = std::move(command);
  status.command.override_percent = override_percent(robot);
  describe_stream(robot.motion, status.command);
  if (wanted.joints) {
    status.joints = joint_statuses(robot, joint_count, sources.joints, settings);
  }
  if (wanted.pose) {
    status.pose = pose_status(robot, joint_count, sources.joints, settings);
  }
  if (wanted.gripper && robot.tool_mounted) {
    status.gripper = gripper_status(*snapshot.cell, robot, sources.parameters, settings);
  }
  if (wanted.settings) status.settings = settings_status(sources, settings);
  if (wanted.sensors) {
    status.sensors = sources.parameters.sensors().statuses(
        snapshot, index, static_cast<std::int32_t>(snapshot.step & 0x7FFFFFFF),
        sources.start_ms + snapshot.time / std::chrono::milliseconds(1), settings.units());
  }
  // NIST's servers never hide guards.
  if (wanted.guards || !sources.guarded.entries.empty()) {
    status.guards =
        guards_statuses(sources.guarded, robot.guards, sources.start_ms, settings.units());
  }
  return status;
}

}  // namespace aprsim::crcl_server
