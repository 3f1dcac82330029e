#include <array>
#include <span>
#include <utility>

#include "crcl/command_reader.hpp"
#include "crcl/decoder.hpp"
#include "crcl/fields.hpp"
#include "crcl/pose.hpp"
#include "crcl/sensor_codec.hpp"
#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

// An element whose abstract schema type must be made concrete by xsi:type.
void fail_type(const Fields& fields, std::string expected) {
  const std::string_view type = fields.type();
  fields.fail("", type,
              type.empty() ? "xsi:type missing, expected " + expected
                           : "unknown xsi:type, expected " + expected,
              ErrorKind::kMalformed);
}

// `base` is TransSpeed, TransAccel, RotSpeed or RotAccel.
Rate read_rate(const Fields& rate, const std::string& base) {
  if (rate.type() == base + "AbsoluteType") return {false, rate.number("Setting")};
  if (rate.type() == base + "RelativeType") return {true, rate.number("Fraction")};
  fail_type(rate, base + "AbsoluteType or " + base + "RelativeType");
  return {};
}

std::optional<Rate> read_optional_rate(const Fields& parent, const std::string& base) {
  if (!parent.has(base)) return std::nullopt;
  return read_rate(parent.child(base), base);
}

PoseSettings read_pose_settings(const Fields& pose) {
  PoseSettings settings;
  settings.coordinated = pose.flag("Coordinated");
  settings.trans_speed = read_optional_rate(pose, "TransSpeed");
  settings.rot_speed = read_optional_rate(pose, "RotSpeed");
  settings.trans_accel = read_optional_rate(pose, "TransAccel");
  settings.rot_accel = read_optional_rate(pose, "RotAccel");
  if (pose.has("Tolerance")) settings.tolerance = read_pose_tolerance(pose.child("Tolerance"));
  return settings;
}

Waypoint read_waypoint(const Fields& fields) {
  Waypoint point{read_pose(fields), std::nullopt};
  if (const Result<Axes> axes = orthonormal_axes(point.pose); !axes) {
    fields.fail(axes.error().element, axes.error().value, axes.error().expected);
  }
  if (fields.type() == "PoseAndSetType") {
    point.settings = read_pose_settings(fields);
  } else if (!fields.type().empty() && fields.type() != "PoseType") {
    fail_type(fields, "PoseType or PoseAndSetType");
  }
  return point;
}

MoveTo read_move_to(const Fields& fields) {
  const Waypoint end = read_waypoint(fields.child("EndPosition"));
  return {fields.flag("MoveStraight"), end.pose, end.settings};
}

MoveThroughTo read_move_through_to(const Fields& fields) {
  MoveThroughTo move;
  move.straight = fields.flag("MoveStraight");
  for (const Fields& point : fields.children("Waypoint")) {
    move.waypoints.push_back(read_waypoint(point));
  }
  if (move.waypoints.size() < 2) {
    fields.fail("Waypoint", std::to_string(move.waypoints.size()) + " of them",
                "expected 2 or more");
  }
  const std::optional<int> count = fields.optional_integer("NumPositions");
  if (count && *count != static_cast<int>(move.waypoints.size())) {
    fields.fail(
        "NumPositions", std::to_string(*count),
        "expected the number of Waypoint elements, " + std::to_string(move.waypoints.size()));
  }
  return move;
}

MoveScrew read_move_screw(const Fields& fields) {
  MoveScrew screw;
  if (fields.has("StartPosition")) screw.start = read_waypoint(fields.child("StartPosition"));
  if (fields.has("AxisPoint")) screw.axis_point = read_point(fields.child("AxisPoint"));
  screw.free_travel = fields.optional_number("AxialDistanceFree");
  screw.screw_travel = fields.number("AxialDistanceScrew");
  screw.turn = fields.number("Turn");
  return screw;
}

ActuateJoint read_actuate_joint(const Fields& fields) {
  ActuateJoint joint;
  joint.joint = fields.integer("JointNumber");
  joint.position = fields.number("JointPosition");
  if (!fields.has("JointDetails")) return joint;
  const Fields details = fields.child("JointDetails");
  if (details.type() == "JointSpeedAccelType") {
    joint.details = JointSpeedAccel{details.optional_number("JointSpeed"),
                                    details.optional_number("JointAccel")};
  } else if (details.type() == "JointForceTorqueType") {
    joint.details =
        JointForceTorque{details.optional_number("Setting"), details.optional_number("ChangeRate")};
  } else {
    fail_type(details, "JointSpeedAccelType or JointForceTorqueType");
  }
  return joint;
}

ActuateJoints read_actuate_joints(const Fields& fields) {
  ActuateJoints command;
  for (const Fields& joint : fields.children("ActuateJoint")) {
    command.joints.push_back(read_actuate_joint(joint));
  }
  if (command.joints.empty()) fields.fail("ActuateJoint", "", "missing");
  if (fields.has("JointTolerances")) {
    command.tolerances = read_joint_tolerances(fields.child("JointTolerances"));
  }
  return command;
}

StopMotion read_stop(const Fields& fields) {
  const std::string condition = fields.optional_text("StopCondition").value_or("");
  if (trim(condition) == "Immediate") return {StopCondition::kImmediate};
  if (trim(condition) == "Normal") return {StopCondition::kNormal};
  return {StopCondition::kFast};
}

template <typename Unit>
SetUnits read_units(const Fields& fields) {
  const std::string name = fields.text("UnitName");
  const std::optional<Unit> unit = unit_named<Unit>(trim(name));
  if (!unit) fields.fail("UnitName", name, "expected " + std::string(unit_choices<Unit>()));
  return {unit.value_or(Unit{})};
}

ConfigureJointReports read_joint_reports(const Fields& fields) {
  ConfigureJointReports command{fields.flag("ResetAll"), {}};
  for (const Fields& report : fields.children("ConfigureJointReport")) {
    command.reports.push_back({report.integer("JointNumber"), report.flag("ReportPosition"),
                               report.flag("ReportTorqueOrForce"), report.flag("ReportVelocity")});
  }
  return command;
}

ConfigureStatusReport read_status_report(const Fields& fields) {
  return {fields.flag("ReportJointStatuses"), fields.flag("ReportPoseStatus"),
          fields.flag("ReportGripperStatus"), fields.flag("ReportSettingsStatus"),
          fields.flag("ReportSensorsStatus"), fields.flag("ReportGuardsStatus")};
}

template <RateKind kKind>
CommandBody read_set_rate(const Fields& fields) {
  constexpr std::array<const char*, 4> kBases{"TransSpeed", "TransAccel", "RotSpeed", "RotAccel"};
  const char* base = kBases[static_cast<std::size_t>(kKind)];
  return SetRate{kKind, read_rate(fields.child(base), base)};
}

template <auto kRead>
CommandBody as_body(const Fields& fields) {
  return kRead(fields);
}

template <typename Empty>
CommandBody read_empty(const Fields&) {
  return Empty{};
}

constexpr CommandReader kReaders[] = {
    {"InitCanonType", read_empty<InitCanon>},
    {"EndCanonType", read_empty<EndCanon>},
    {"GetStatusType", read_empty<GetStatus>},
    {"StopMotionType", as_body<read_stop>},
    {"MoveToType", as_body<read_move_to>},
    {"MoveThroughToType", as_body<read_move_through_to>},
    {"MoveScrewType", as_body<read_move_screw>},
    {"ActuateJointsType", as_body<read_actuate_joints>},
    {"SetEndEffectorType",
     [](const Fields& f) -> CommandBody { return SetEndEffector{f.number("Setting")}; }},
    {"OpenToolChangerType", read_empty<OpenToolChanger>},
    {"CloseToolChangerType", read_empty<CloseToolChanger>},
    {"DwellType", [](const Fields& f) -> CommandBody { return Dwell{f.number("DwellTime")}; }},
    {"MessageType", [](const Fields& f) -> CommandBody { return Message{f.text("Message")}; }},
    {"SetLengthUnitsType", as_body<read_units<LengthUnit>>},
    {"SetAngleUnitsType", as_body<read_units<AngleUnit>>},
    {"SetForceUnitsType", as_body<read_units<ForceUnit>>},
    {"SetTorqueUnitsType", as_body<read_units<TorqueUnit>>},
    {"SetTransSpeedType", read_set_rate<RateKind::kTransSpeed>},
    {"SetTransAccelType", read_set_rate<RateKind::kTransAccel>},
    {"SetRotSpeedType", read_set_rate<RateKind::kRotSpeed>},
    {"SetRotAccelType", read_set_rate<RateKind::kRotAccel>},
    {"SetEndPoseToleranceType",
     [](const Fields& f) -> CommandBody {
       return SetEndPoseTolerance{read_pose_tolerance(f.child("Tolerance"))};
     }},
    {"SetIntermediatePoseToleranceType",
     [](const Fields& f) -> CommandBody {
       return SetIntermediatePoseTolerance{read_pose_tolerance(f.child("Tolerance"))};
     }},
    {"SetDefaultJointPositonsTolerancesType",
     [](const Fields& f) -> CommandBody {
       return SetDefaultJointTolerances{read_joint_tolerances(f.child("JointTolerances"))};
     }},
    {"ConfigureJointReportsType", as_body<read_joint_reports>},
    {"ConfigureStatusReportType", as_body<read_status_report>},
    {"LoopBlockStartType",
     [](const Fields& f) -> CommandBody { return LoopBlockStart{f.text("LoopName")}; }},
    {"LoopBlockEndType",
     [](const Fields& f) -> CommandBody {
       return LoopBlockEnd{f.text("LoopName"), f.integer("MaxCount")};
     }},
};

CommandBody read_body(const Fields& fields, std::string_view type) {
  for (const std::span<const CommandReader> readers :
       {std::span<const CommandReader>(kReaders), service_readers()}) {
    for (const CommandReader& reader : readers) {
      if (reader.type == type) return reader.read(fields);
    }
  }
  fail_type(fields, "a command type of CRCLCommands.xsd");
  return {};
}

// Reads a command element whose type is `type`; faults go to the slot, with the command's identity.
Command read_command(const XmlNode& node, std::string_view type, ErrorSlot& slot) {
  Command command;
  const bool clean = !slot.has_value();
  const Fields fields(node, slot);
  command.name = fields.optional_text("Name");
  command.id = fields.optional_long("CommandID").value_or(0);
  for (const Fields& guard : fields.children("Guard")) command.guards.push_back(read_guard(guard));
  command.body = read_body(fields, type);
  if (clean && slot) {
    slot->command_type = type;
    slot->command_id = command.id;
  }
  return command;
}

// Where a client is in its program is only echoed: no reason to refuse a command.
std::optional<int> read_hint(const XmlNode& root, std::string_view name) {
  const XmlNode* node = root.child(name);
  return node == nullptr ? std::nullopt : parse_int(node->text);
}

tl::unexpected<Error> wrong_root(const XmlNode& root, std::string expected) {
  Error error;
  error.element = shorten(root.name);
  error.expected = "expected the root element " + std::move(expected);
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace

Result<CommandInstance> decode_command(std::string_view document, std::size_t max_bytes) {
  const Result<XmlNode> root = parse_xml(document, {.max_bytes = max_bytes});
  if (!root) return tl::unexpected<Error>(root.error());
  if (root->name != "CRCLCommandInstance") return wrong_root(*root, "CRCLCommandInstance");
  const XmlNode* node = root->child("CRCLCommand");
  ErrorSlot slot;
  const Fields fields(*root, slot);
  if (node == nullptr) {
    fields.fail("CRCLCommand", "", "missing", ErrorKind::kMalformed);
    return tl::unexpected<Error>(*slot);
  }
  CommandInstance instance;
  instance.command = read_command(*node, node->type, slot);
  instance.name = fields.optional_text("Name");
  instance.program_file = fields.optional_text("ProgramFile");
  instance.program_index = read_hint(*root, "ProgramIndex");
  instance.program_length = read_hint(*root, "ProgramLength");
  if (slot) return tl::unexpected<Error>(std::move(*slot));
  return instance;
}

Result<Program> decode_program(std::string_view document, std::size_t max_bytes) {
  const Result<XmlNode> root = parse_xml(document, {.max_bytes = max_bytes});
  if (!root) return tl::unexpected<Error>(root.error());
  if (root->name != "CRCLProgram") return wrong_root(*root, "CRCLProgram");
  Program program;
  ErrorSlot slot;
  program.name = Fields(*root, slot).optional_text("Name");
  for (const XmlNode& node : root->children) {
    if (node.name == "InitCanon") {
      program.commands.push_back(read_command(node, "InitCanonType", slot));
    } else if (node.name == "EndCanon") {
      program.commands.push_back(read_command(node, "EndCanonType", slot));
    } else if (node.name == "MiddleCommand") {
      program.commands.push_back(read_command(node, node.type, slot));
    }
    if (slot) return tl::unexpected<Error>(std::move(*slot));
  }
  return program;
}

}  // namespace aprsim::crcl
