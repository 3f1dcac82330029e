#include <string>

#include "crcl/encoder.hpp"
#include "crcl/sensor_codec.hpp"
#include "crcl/value_writer.hpp"

namespace aprsim::crcl {
namespace {

void write_command_status(XmlWriter& out, const CommandStatus& status) {
  out.open("CommandStatus");
  write_optional(out, "Name", status.name);
  out.integer("CommandID", status.command_id);
  out.integer("StatusID", status.status_id);
  out.text("CommandState", name_of(status.state));
  write_optional(out, "StateDescription", status.description);
  write_optional(out, "ProgramFile", status.program_file);
  write_optional(out, "ProgramIndex", status.program_index);
  write_optional(out, "ProgramLength", status.program_length);
  write_optional(out, "OverridePercent", status.override_percent);
  out.close("CommandStatus");
}

void write_joints(XmlWriter& out, const std::vector<JointStatus>& joints) {
  if (joints.empty()) return;  // the schema asks for at least one
  out.open("JointStatuses");
  for (const JointStatus& joint : joints) {
    out.open("JointStatus");
    out.integer("JointNumber", joint.joint);
    write_optional(out, "JointPosition", joint.position);
    write_optional(out, "JointTorqueOrForce", joint.torque);
    write_optional(out, "JointVelocity", joint.velocity);
    out.close("JointStatus");
  }
  out.close("JointStatuses");
}

void write_pose_status(XmlWriter& out, const PoseStatus& status) {
  out.open("PoseStatus");
  out.open("Pose");
  write_pose_elements(out, status.pose);
  out.close("Pose");
  if (status.twist) {
    out.open("Twist");
    write_vector(out, "LinearVelocity", status.twist->linear);
    write_vector(out, "AngularVelocity", status.twist->angular);
    out.close("Twist");
  }
  if (status.wrench) {
    out.open("Wrench");
    write_vector(out, "Force", status.wrench->force);
    write_vector(out, "Moment", status.wrench->moment);
    out.close("Wrench");
  }
  write_optional(out, "Configuration", status.configuration);
  out.close("PoseStatus");
}

struct GripperWriter {
  XmlWriter& out;

  void operator()(const ParallelGripper& gripper) const {
    out.number("Separation", gripper.separation);
  }
  void operator()(const ThreeFingerGripper& gripper) const {
    for (std::size_t i = 0; i < 3; ++i) {
      write_optional(out, "Finger" + std::to_string(i + 1) + "Position", gripper.position[i]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      write_optional(out, "Finger" + std::to_string(i + 1) + "Force", gripper.force[i]);
    }
  }
  void operator()(const VacuumGripper& gripper) const { out.flag("IsPowered", gripper.powered); }
};

void write_gripper(XmlWriter& out, const GripperStatus& status) {
  constexpr const char* kTypes[] = {"ParallelGripperStatusType", "ThreeFingerGripperStatusType",
                                    "VacuumGripperStatusType"};
  out.open("GripperStatus", kTypes[status.kind.index()]);
  out.text("GripperName", status.name);
  write_parameters(out, "GripperOption", status.options);
  write_optional(out, "HoldingObject", status.holding);
  std::visit(GripperWriter{out}, status.kind);
  out.close("GripperStatus");
}

void write_joint_limits(XmlWriter& out, const JointLimits& limits) {
  out.open("JointLimits");
  out.integer("JointNumber", limits.joint);
  write_optional(out, "JointMinPosition", limits.min_position);
  write_optional(out, "JointMaxPosition", limits.max_position);
  write_optional(out, "JointMaxTorqueOrForce", limits.max_torque);
  write_optional(out, "JointMaxVelocity", limits.max_velocity);
  out.close("JointLimits");
}

// In a settings report the element name says absolute or relative, so no xsi:type is needed.
void write_set_rate(XmlWriter& out, const std::string& base, const std::optional<Rate>& rate) {
  if (!rate) return;
  const std::string name = base + (rate->relative ? "Relative" : "Absolute");
  out.open(name);
  out.number(rate->relative ? "Fraction" : "Setting", rate->value);
  out.close(name);
}

template <typename Unit>
void write_unit(XmlWriter& out, std::string_view name, const std::optional<Unit>& unit) {
  if (unit) out.text(name, name_of(*unit));
}

void write_settings(XmlWriter& out, const SettingsStatus& settings) {
  out.open("SettingsStatus");
  write_unit(out, "AngleUnitName", settings.angle_unit);
  write_parameters(out, "EndEffectorParameterSetting", settings.end_effector_parameters);
  write_optional(out, "EndEffectorSetting", settings.end_effector);
  write_unit(out, "ForceUnitName", settings.force_unit);
  for (const JointLimits& limits : settings.joint_limits) write_joint_limits(out, limits);
  if (settings.intermediate_tolerance) {
    write_tolerance(out, "IntermediatePoseTolerance", *settings.intermediate_tolerance);
  }
  write_unit(out, "LengthUnitName", settings.length_unit);
  if (settings.max_cartesian) write_point(out, "MaxCartesianLimit", *settings.max_cartesian);
  if (settings.min_cartesian) write_point(out, "MinCartesianLimit", *settings.min_cartesian);
  write_optional(out, "MotionCoordinated", settings.coordinated);
  if (settings.end_tolerance) write_tolerance(out, "EndPoseTolerance", *settings.end_tolerance);
  write_parameters(out, "RobotParameterSetting", settings.robot_parameters);
  write_set_rate(out, "RotAccel", settings.rot_accel);
  write_set_rate(out, "RotSpeed", settings.rot_speed);
  write_unit(out, "TorqueUnitName", settings.torque_unit);
  write_set_rate(out, "TransAccel", settings.trans_accel);
  write_set_rate(out, "TransSpeed", settings.trans_speed);
  if (!settings.joint_tolerances.empty()) {
    write_joint_tolerances(out, "JointTolerances", settings.joint_tolerances);
  }
  out.close("SettingsStatus");
}

}  // namespace

std::string_view name_of(CommandState state) {
  switch (state) {
    case CommandState::kDone:
      return "CRCL_Done";
    case CommandState::kError:
      return "CRCL_Error";
    case CommandState::kWorking:
      return "CRCL_Working";
    case CommandState::kReady:
      break;
  }
  return "CRCL_Ready";
}

std::string encode_status(const Status& status) {
  XmlWriter out;
  out.open("CRCLStatus");
  write_optional(out, "Name", status.name);
  write_command_status(out, status.command);
  write_joints(out, status.joints);
  if (status.pose) write_pose_status(out, *status.pose);
  if (status.gripper) write_gripper(out, *status.gripper);
  if (status.settings) write_settings(out, *status.settings);
  if (status.sensors) write_sensor_statuses(out, *status.sensors);
  if (status.guards) write_guards_statuses(out, *status.guards);
  out.close("CRCLStatus");
  return out.take();
}

}  // namespace aprsim::crcl
