#include "crcl/status_decoder.hpp"

#include <string>
#include <utility>

#include "crcl/fields.hpp"
#include "crcl/sensor_codec.hpp"
#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

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

// When both forms stand, the absolute one says more.
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

Status read_status(const Fields& fields) {
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

Result<Status> decode_status(std::string_view document, std::size_t max_bytes) {
  const Result<XmlNode> root = parse_xml(document, {.max_bytes = max_bytes});
  if (!root) return tl::unexpected<Error>(root.error());
  ErrorSlot slot;
  const Fields fields(*root, slot);
  if (root->name != "CRCLStatus") {
    fields.fail("", "", "expected the root element CRCLStatus", ErrorKind::kMalformed);
    return tl::unexpected<Error>(std::move(*slot));
  }
  Status status = read_status(fields);
  if (slot) return tl::unexpected<Error>(std::move(*slot));
  return status;
}

}  // namespace aprsim::crcl
