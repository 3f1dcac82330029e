#include "crcl/status_codec.hpp"

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "crcl/document_codec.hpp"
#include "crcl/sensor_codec.hpp"
#include "crcl/text.hpp"
#include "crcl/value_codec.hpp"
#include "crcl/xml_writer.hpp"

namespace aprsim::crcl {
namespace {

// Writing.

void write_command_status(ElementWriter& out, const CommandStatus& status) {
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

void write_joints(ElementWriter& out, const std::vector<JointStatus>& joints) {
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

void write_pose_status(ElementWriter& out, const PoseStatus& status) {
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
  ElementWriter& out;

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

void write_gripper(ElementWriter& out, const GripperStatus& status) {
  constexpr const char* kTypes[] = {"ParallelGripperStatusType", "ThreeFingerGripperStatusType",
                                    "VacuumGripperStatusType"};
  out.open("GripperStatus", kTypes[status.kind.index()]);
  out.text("GripperName", status.name);
  write_parameters(out, "GripperOption", status.options);
  write_optional(out, "HoldingObject", status.holding);
  std::visit(GripperWriter{out}, status.kind);
  out.close("GripperStatus");
}

void write_joint_limits(ElementWriter& out, const JointLimits& limits) {
  out.open("JointLimits");
  out.integer("JointNumber", limits.joint);
  write_optional(out, "JointMinPosition", limits.min_position);
  write_optional(out, "JointMaxPosition", limits.max_position);
  write_optional(out, "JointMaxTorqueOrForce", limits.max_torque);
  write_optional(out, "JointMaxVelocity", limits.max_velocity);
  out.close("JointLimits");
}

// In a settings report the element name says absolute or relative, so no xsi:type is needed.
void write_set_rate(ElementWriter& out, const std::string& base, const std::optional<Rate>& rate) {
  if (!rate) return;
  const std::string name = base + (rate->relative ? "Relative" : "Absolute");
  out.open(name);
  out.number(rate->relative ? "Fraction" : "Setting", rate->value);
  out.close(name);
}

template <typename Unit>
void write_unit(ElementWriter& out, std::string_view name, const std::optional<Unit>& unit) {
  if (unit) out.text(name, name_of(*unit));
}

void write_settings(ElementWriter& out, const SettingsStatus& settings) {
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

// Reading.

CommandState read_state(const Fields& fields) {
  const std::string text = fields.text("CommandState");
  for (const CommandState state :
       {CommandState::kDone, CommandState::kError, CommandState::kWorking, CommandState::kReady}) {
    if (trim(text) == name_of(state)) return state;
  }
  fields.fail("CommandState", text, "expected CRCL_Done, CRCL_Error, CRCL_Working or CRCL_Ready");
  return {};
}

CommandStatus read_command_status(const Fields& fields) {
  CommandStatus status;
  status.name = fields.optional_text("Name");
  status.command_id = fields.optional_long("CommandID").value_or(0);
  status.status_id = fields.optional_long("StatusID").value_or(0);
  status.state = read_state(fields);
  status.description = fields.optional_text("StateDescription");
  status.program_file = fields.optional_text("ProgramFile");
  status.program_index = fields.optional_integer("ProgramIndex");
  status.program_length = fields.optional_integer("ProgramLength");
  status.override_percent = fields.optional_integer("OverridePercent");
  return status;
}

JointStatus read_joint(const Fields& fields) {
  return {fields.integer("JointNumber"), fields.optional_number("JointPosition"),
          fields.optional_number("JointTorqueOrForce"), fields.optional_number("JointVelocity")};
}

PoseStatus read_pose_status(const Fields& fields) {
  PoseStatus status;
  status.pose = read_pose(fields.child("Pose"));
  if (fields.has("Twist")) {
    const Fields twist = fields.child("Twist");
    status.twist = Twist{read_vector(twist.child("LinearVelocity")),
                         read_vector(twist.child("AngularVelocity"))};
  }
  if (fields.has("Wrench")) {
    const Fields wrench = fields.child("Wrench");
    status.wrench = Wrench{read_vector(wrench.child("Force")), read_vector(wrench.child("Moment"))};
  }
  status.configuration = fields.optional_text("Configuration");
  return status;
}

ThreeFingerGripper read_three_fingers(const Fields& fields) {
  ThreeFingerGripper gripper;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string finger = "Finger" + std::to_string(i + 1);
    gripper.position[i] = fields.optional_number(finger + "Position");
    gripper.force[i] = fields.optional_number(finger + "Force");
  }
  return gripper;
}

GripperStatus read_gripper(const Fields& fields) {
  GripperStatus status;
  status.name = trim(fields.text("GripperName"));
  status.options = read_parameters(fields, "GripperOption");
  status.holding = fields.optional_flag("HoldingObject");
  if (fields.type() == "ParallelGripperStatusType") {
    status.kind = ParallelGripper{fields.number("Separation")};
  } else if (fields.type() == "ThreeFingerGripperStatusType") {
    status.kind = read_three_fingers(fields);
  } else if (fields.type() == "VacuumGripperStatusType") {
    status.kind = VacuumGripper{fields.flag("IsPowered")};
  } else {
    fields.fail("", fields.type(), "expected the xsi:type of a gripper status",
                ErrorKind::kMalformed);
  }
  return status;
}

template <typename Unit>
std::optional<Unit> read_unit(const Fields& fields, std::string_view name) {
  const std::optional<std::string> text = fields.optional_text(name);
  if (!text) return std::nullopt;
  const std::optional<Unit> unit = unit_named<Unit>(trim(*text));
  if (!unit) fields.fail(name, *text, "expected " + std::string(unit_choices<Unit>()));
  return unit;
}

// The absolute form takes precedence.
std::optional<Rate> read_set_rate(const Fields& fields, const std::string& base) {
  if (fields.has(base + "Absolute")) {
    return Rate{false, fields.child(base + "Absolute").number("Setting")};
  }
  if (fields.has(base + "Relative")) {
    return Rate{true, fields.child(base + "Relative").number("Fraction")};
  }
  return std::nullopt;
}

std::optional<PoseTolerance> read_tolerance(const Fields& fields, std::string_view name) {
  if (!fields.has(name)) return std::nullopt;
  return read_pose_tolerance(fields.child(name));
}

std::optional<Vector> read_corner(const Fields& fields, std::string_view name) {
  if (!fields.has(name)) return std::nullopt;
  return read_point(fields.child(name));
}

SettingsStatus read_settings(const Fields& fields) {
  SettingsStatus settings;
  settings.angle_unit = read_unit<AngleUnit>(fields, "AngleUnitName");
  settings.end_effector_parameters = read_parameters(fields, "EndEffectorParameterSetting");
  settings.end_effector = fields.optional_number("EndEffectorSetting");
  settings.force_unit = read_unit<ForceUnit>(fields, "ForceUnitName");
  for (const Fields& limits : fields.children("JointLimits")) {
    settings.joint_limits.push_back({limits.integer("JointNumber"),
                                     limits.optional_number("JointMinPosition"),
                                     limits.optional_number("JointMaxPosition"),
                                     limits.optional_number("JointMaxTorqueOrForce"),
                                     limits.optional_number("JointMaxVelocity")});
  }
  settings.intermediate_tolerance = read_tolerance(fields, "IntermediatePoseTolerance");
  settings.length_unit = read_unit<LengthUnit>(fields, "LengthUnitName");
  settings.max_cartesian = read_corner(fields, "MaxCartesianLimit");
  settings.min_cartesian = read_corner(fields, "MinCartesianLimit");
  settings.coordinated = fields.optional_flag("MotionCoordinated");
  settings.end_tolerance = read_tolerance(fields, "EndPoseTolerance");
  settings.robot_parameters = read_parameters(fields, "RobotParameterSetting");
  settings.rot_accel = read_set_rate(fields, "RotAccel");
  settings.rot_speed = read_set_rate(fields, "RotSpeed");
  settings.torque_unit = read_unit<TorqueUnit>(fields, "TorqueUnitName");
  settings.trans_accel = read_set_rate(fields, "TransAccel");
  settings.trans_speed = read_set_rate(fields, "TransSpeed");
  if (fields.has("JointTolerances")) {
    settings.joint_tolerances = read_joint_tolerances(fields.child("JointTolerances"));
  }
  return settings;
}

Status read_parts(const Fields& fields) {
  Status status;
  status.name = fields.optional_text("Name");
  status.command = read_command_status(fields.child("CommandStatus"));
  if (fields.has("JointStatuses")) {
    const Fields joints = fields.child("JointStatuses");
    for (const Fields& joint : joints.children("JointStatus")) {
      status.joints.push_back(read_joint(joint));
    }
  }
  if (fields.has("PoseStatus")) status.pose = read_pose_status(fields.child("PoseStatus"));
  if (fields.has("GripperStatus")) status.gripper = read_gripper(fields.child("GripperStatus"));
  if (fields.has("SettingsStatus")) {
    status.settings = read_settings(fields.child("SettingsStatus"));
  }
  if (fields.has("SensorStatuses")) {
    status.sensors = read_sensor_statuses(fields.child("SensorStatuses"));
  }
  if (fields.has("GuardsStatuses")) {
    status.guards = read_guards_statuses(fields.child("GuardsStatuses"));
  }
  return status;
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
  write_status(out, status);
  return std::move(out).document();
}

Result<Status> decode_status(std::string_view document, std::size_t max_bytes) {
  return parse_xml(document, {.max_bytes = max_bytes}).and_then(read_status);
}

void write_status(ElementWriter& out, const Status& status) {
  out.open(kStatusRoot);
  write_optional(out, "Name", status.name);
  write_command_status(out, status.command);
  write_joints(out, status.joints);
  if (status.pose) write_pose_status(out, *status.pose);
  if (status.gripper) write_gripper(out, *status.gripper);
  if (status.settings) write_settings(out, *status.settings);
  if (status.sensors) write_sensor_statuses(out, *status.sensors);
  if (status.guards) write_guards_statuses(out, *status.guards);
  out.close(kStatusRoot);
}

Result<Status> read_status(const XmlNode& root) {
  ErrorSlot slot;
  const Fields fields(root, slot);
  if (root.name != kStatusRoot) {
    fields.fail("", "", "expected the root element CRCLStatus", ErrorKind::kMalformed);
    return tl::unexpected<Error>(std::move(*slot));
  }
  Status status = read_parts(fields);
  if (slot) return tl::unexpected<Error>(std::move(*slot));
  return status;
}

}  // namespace aprsim::crcl
