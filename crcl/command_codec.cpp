#include "crcl/command_codec.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "crcl/document_codec.hpp"
#include "crcl/sensor_codec.hpp"
#include "crcl/text.hpp"
#include "crcl/value_codec.hpp"
#include "crcl/xml_writer.hpp"

namespace aprsim::crcl {

// Copied and destroyed here only: the code for so many alternatives is large.
CommandBody::CommandBody() = default;
CommandBody::CommandBody(const CommandBody& other) = default;
CommandBody::CommandBody(CommandBody&& other) noexcept = default;
CommandBody& CommandBody::operator=(const CommandBody& other) = default;
CommandBody& CommandBody::operator=(CommandBody&& other) noexcept = default;
CommandBody::~CommandBody() = default;

bool CommandBody::operator==(const CommandBody& other) const {
  return static_cast<const AnyCommand&>(*this) == static_cast<const AnyCommand&>(other);
}

namespace {

constexpr std::array<const char*, 4> kRateElements{"TransSpeed", "TransAccel", "RotSpeed",
                                                   "RotAccel"};

// Reading.

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
  return {fields.flag("MoveStraight"), end};
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
SetRate read_set_rate(const Fields& fields) {
  const char* base = kRateElements[static_cast<std::size_t>(kKind)];
  return {kKind, read_rate(fields.child(base), base)};
}

template <typename Empty>
Empty read_empty(const Fields&) {
  return Empty{};
}

// A name without white space around it, as xs:token has it; an empty one names nothing.
std::string read_token(const Fields& fields, std::string_view element) {
  std::string text(trim(fields.text(element)));
  if (text.empty() && fields.has(element)) fields.fail(element, "", "expected a name");
  return text;
}

std::vector<ParameterSetting> read_parameters(const Fields& fields) {
  std::vector<ParameterSetting> settings = read_parameters(fields, "ParameterSetting");
  if (settings.empty()) fields.fail("ParameterSetting", "", "missing");
  return settings;
}

// One type of the schema: its name, the alternative of CommandBody that it becomes, its reader.
struct CommandType {
  std::string_view name;  // xsi:type
  std::size_t alternative;
  CommandBody (*read)(const Fields& command);
};

template <typename Body, typename... Bodies>
constexpr std::size_t index_in(const std::variant<Bodies...>*) {
  std::size_t index = 0;
  static_cast<void>(((std::is_same_v<Body, Bodies> || (++index, false)) || ...));
  return index;
}

// kRead makes one of the command structs of the elements.
template <auto kRead>
constexpr CommandType row(std::string_view name) {
  using Body = std::invoke_result_t<decltype(kRead), const Fields&>;
  return {name, index_in<Body>(static_cast<const CommandBody*>(nullptr)),
          [](const Fields& fields) -> CommandBody { return kRead(fields); }};
}

// The types of one alternative stand together, in the order of its units or rates.
constexpr CommandType kCommandTypes[] = {
    row<read_empty<InitCanon>>("InitCanonType"),
    row<read_empty<EndCanon>>("EndCanonType"),
    row<read_empty<GetStatus>>("GetStatusType"),
    row<read_stop>("StopMotionType"),
    row<read_move_to>("MoveToType"),
    row<read_move_through_to>("MoveThroughToType"),
    row<read_move_screw>("MoveScrewType"),
    row<read_actuate_joints>("ActuateJointsType"),
    row<[](const Fields& f) { return SetEndEffector{f.number("Setting")}; }>("SetEndEffectorType"),
    row<read_empty<OpenToolChanger>>("OpenToolChangerType"),
    row<read_empty<CloseToolChanger>>("CloseToolChangerType"),
    row<[](const Fields& f) { return Dwell{f.number("DwellTime")}; }>("DwellType"),
    row<[](const Fields& f) { return Message{f.text("Message")}; }>("MessageType"),
    row<read_units<LengthUnit>>("SetLengthUnitsType"),
    row<read_units<AngleUnit>>("SetAngleUnitsType"),
    row<read_units<ForceUnit>>("SetForceUnitsType"),
    row<read_units<TorqueUnit>>("SetTorqueUnitsType"),
    row<read_set_rate<RateKind::kTransSpeed>>("SetTransSpeedType"),
    row<read_set_rate<RateKind::kTransAccel>>("SetTransAccelType"),
    row<read_set_rate<RateKind::kRotSpeed>>("SetRotSpeedType"),
    row<read_set_rate<RateKind::kRotAccel>>("SetRotAccelType"),
    row<[](const Fields& f) {
      return SetEndPoseTolerance{read_pose_tolerance(f.child("Tolerance"))};
    }>("SetEndPoseToleranceType"),
    row<[](const Fields& f) {
      return SetIntermediatePoseTolerance{read_pose_tolerance(f.child("Tolerance"))};
    }>("SetIntermediatePoseToleranceType"),
    row<[](const Fields& f) {
      return SetDefaultJointTolerances{read_joint_tolerances(f.child("JointTolerances"))};
    }>("SetDefaultJointPositonsTolerancesType"),
    row<read_joint_reports>("ConfigureJointReportsType"),
    row<read_status_report>("ConfigureStatusReportType"),
    row<[](const Fields& f) { return LoopBlockStart{f.text("LoopName")}; }>("LoopBlockStartType"),
    row<[](const Fields& f) {
      return LoopBlockEnd{f.text("LoopName"), f.integer("MaxCount")};
    }>("LoopBlockEndType"),
    row<[](const Fields& f) { return SetEndEffectorParameters{read_parameters(f)}; }>(
        "SetEndEffectorParametersType"),
    row<[](const Fields& f) { return SetRobotParameters{read_parameters(f)}; }>(
        "SetRobotParametersType"),
    row<[](const Fields& f) {
      return EnableGripper{read_token(f, "GripperName"), read_parameters(f, "GripperOption")};
    }>("EnableGripperType"),
    row<[](const Fields& f) { return DisableGripper{read_token(f, "GripperName")}; }>(
        "DisableGripperType"),
    row<[](const Fields& f) {
      return EnableSensor{read_token(f, "SensorID"), read_parameters(f, "SensorOption")};
    }>("EnableSensorType"),
    row<[](const Fields& f) { return DisableSensor{read_token(f, "SensorID")}; }>(
        "DisableSensorType"),
    row<[](const Fields& f) {
      return EnableRobotParameterStatus{read_token(f, "RobotParameterName")};
    }>("EnableRobotParameterStatusType"),
    row<[](const Fields& f) {
      return DisableRobotParameterStatus{read_token(f, "RobotParameterName")};
    }>("DisableRobotParameterStatusType"),
    row<[](const Fields& f) { return SetMotionCoordination{f.flag("Coordinated")}; }>(
        "SetMotionCoordinationType"),
    row<[](const Fields& f) { return RunProgram{f.text("ProgramText")}; }>("RunProgramType"),
};

CommandBody read_body(const Fields& fields, std::string_view type) {
  for (const CommandType& known : kCommandTypes) {
    if (known.name == type) return known.read(fields);
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

// The program position is only echoed; a bad one is no reason to refuse a command.
std::optional<int> read_hint(const XmlNode& root, std::string_view name) {
  const XmlNode* node = root.child(name);
  return node == nullptr ? std::nullopt : parse_int(node->text);
}

tl::unexpected<Error> wrong_root(const XmlNode& root, std::string_view expected) {
  Error error;
  error.element = shorten(root.name);
  error.expected = "expected the root element " + std::string(expected);
  return tl::unexpected<Error>(std::move(error));
}

// Writing.

void write_rate(ElementWriter& out, const std::string& base, const Rate& rate) {
  out.open(base, base + (rate.relative ? "RelativeType" : "AbsoluteType"));
  out.number(rate.relative ? "Fraction" : "Setting", rate.value);
  out.close(base);
}

void write_rate(ElementWriter& out, const std::string& base, const std::optional<Rate>& rate) {
  if (rate) write_rate(out, base, *rate);
}

void write_pose_settings(ElementWriter& out, const PoseSettings& settings) {
  out.flag("Coordinated", settings.coordinated);
  write_rate(out, "TransSpeed", settings.trans_speed);
  write_rate(out, "RotSpeed", settings.rot_speed);
  write_rate(out, "TransAccel", settings.trans_accel);
  write_rate(out, "RotAccel", settings.rot_accel);
  if (settings.tolerance) write_tolerance(out, "Tolerance", *settings.tolerance);
}

void write_waypoint(ElementWriter& out, std::string_view name, const Waypoint& point) {
  if (point.settings) {
    out.open(name, "PoseAndSetType");
  } else {
    out.open(name);
  }
  write_pose_elements(out, point.pose);
  if (point.settings) write_pose_settings(out, *point.settings);
  out.close(name);
}

void write_joint_details(ElementWriter& out, const JointSpeedAccel& details) {
  out.open("JointDetails", "JointSpeedAccelType");
  write_optional(out, "JointSpeed", details.speed);
  write_optional(out, "JointAccel", details.accel);
  out.close("JointDetails");
}

void write_joint_details(ElementWriter& out, const JointForceTorque& details) {
  out.open("JointDetails", "JointForceTorqueType");
  write_optional(out, "Setting", details.setting);
  write_optional(out, "ChangeRate", details.change_rate);
  out.close("JointDetails");
}

// Writes the fields of a command that follow CommandID and guards.
struct BodyWriter {
  ElementWriter& out;

  void operator()(const InitCanon&) const {}
  void operator()(const EndCanon&) const {}
  void operator()(const GetStatus&) const {}

  void operator()(const StopMotion& stop) const {
    constexpr std::array<const char*, 3> kNames{"Immediate", "Fast", "Normal"};
    out.text("StopCondition", kNames[static_cast<std::size_t>(stop.condition)]);
  }

  void operator()(const MoveTo& move) const {
    out.flag("MoveStraight", move.straight);
    write_waypoint(out, "EndPosition", move.end);
  }

  void operator()(const MoveThroughTo& move) const {
    out.flag("MoveStraight", move.straight);
    for (const Waypoint& point : move.waypoints) write_waypoint(out, "Waypoint", point);
    out.integer("NumPositions", static_cast<int>(move.waypoints.size()));
  }

  void operator()(const MoveScrew& screw) const {
    if (screw.start) write_waypoint(out, "StartPosition", *screw.start);
    if (screw.axis_point) write_point(out, "AxisPoint", *screw.axis_point);
    write_optional(out, "AxialDistanceFree", screw.free_travel);
    out.number("AxialDistanceScrew", screw.screw_travel);
    out.number("Turn", screw.turn);
  }

  void operator()(const ActuateJoints& command) const {
    for (const ActuateJoint& joint : command.joints) {
      out.open("ActuateJoint");
      out.integer("JointNumber", joint.joint);
      out.number("JointPosition", joint.position);
      std::visit([this](const auto& details) { write_joint_details(out, details); }, joint.details);
      out.close("ActuateJoint");
    }
    if (!command.tolerances.empty()) {
      write_joint_tolerances(out, "JointTolerances", command.tolerances);
    }
  }

  void operator()(const SetEndEffector& set) const { out.number("Setting", set.setting); }
  void operator()(const OpenToolChanger&) const {}
  void operator()(const CloseToolChanger&) const {}
  void operator()(const Dwell& dwell) const { out.number("DwellTime", dwell.seconds); }
  void operator()(const Message& message) const { out.text("Message", message.text); }

  void operator()(const SetUnits& set) const {
    std::visit([this](const auto& unit) { out.text("UnitName", name_of(unit)); }, set.unit);
  }

  void operator()(const SetRate& set) const {
    write_rate(out, kRateElements[static_cast<std::size_t>(set.which)], set.rate);
  }

  void operator()(const SetEndPoseTolerance& set) const {
    write_tolerance(out, "Tolerance", set.tolerance);
  }
  void operator()(const SetIntermediatePoseTolerance& set) const {
    write_tolerance(out, "Tolerance", set.tolerance);
  }
  void operator()(const SetDefaultJointTolerances& set) const {
    write_joint_tolerances(out, "JointTolerances", set.tolerances);
  }

  void operator()(const ConfigureJointReports& command) const {
    out.flag("ResetAll", command.reset_all);
    for (const JointReport& report : command.reports) {
      out.open("ConfigureJointReport");
      out.integer("JointNumber", report.joint);
      out.flag("ReportPosition", report.position);
      out.flag("ReportTorqueOrForce", report.torque);
      out.flag("ReportVelocity", report.velocity);
      out.close("ConfigureJointReport");
    }
  }

  void operator()(const ConfigureStatusReport& command) const {
    out.flag("ReportJointStatuses", command.joints);
    out.flag("ReportPoseStatus", command.pose);
    out.flag("ReportGripperStatus", command.gripper);
    out.flag("ReportSettingsStatus", command.settings);
    out.flag("ReportSensorsStatus", command.sensors);
    out.flag("ReportGuardsStatus", command.guards);
  }

  void operator()(const LoopBlockStart& loop) const { out.text("LoopName", loop.loop); }
  void operator()(const LoopBlockEnd& loop) const {
    out.text("LoopName", loop.loop);
    out.integer("MaxCount", loop.max_count);
  }

  void operator()(const SetEndEffectorParameters& command) const {
    write_parameters(out, "ParameterSetting", command.settings);
  }
  void operator()(const SetRobotParameters& command) const {
    write_parameters(out, "ParameterSetting", command.settings);
  }
  void operator()(const EnableGripper& command) const {
    out.text("GripperName", command.gripper);
    write_parameters(out, "GripperOption", command.options);
  }
  void operator()(const DisableGripper& command) const { out.text("GripperName", command.gripper); }
  void operator()(const EnableSensor& command) const {
    out.text("SensorID", command.sensor_id);
    write_parameters(out, "SensorOption", command.options);
  }
  void operator()(const DisableSensor& command) const { out.text("SensorID", command.sensor_id); }
  void operator()(const EnableRobotParameterStatus& command) const {
    out.text("RobotParameterName", command.parameter);
  }
  void operator()(const DisableRobotParameterStatus& command) const {
    out.text("RobotParameterName", command.parameter);
  }
  void operator()(const SetMotionCoordination& command) const {
    out.flag("Coordinated", command.coordinated);
  }
  void operator()(const RunProgram& command) const { out.text("ProgramText", command.text); }
};

void write_command(ElementWriter& out, const Command& command) {
  write_optional(out, "Name", command.name);
  out.integer("CommandID", command.id);
  for (const Guard& guard : command.guards) write_guard(out, guard);
  std::visit(BodyWriter{out}, command.body);
}

}  // namespace

std::string_view type_name(const CommandBody& body) {
  // Among the types of the alternative, which come in the order of these enumerators.
  std::size_t within = 0;
  if (const auto* units = std::get_if<SetUnits>(&body)) within = units->unit.index();
  if (const auto* set = std::get_if<SetRate>(&body)) within = static_cast<std::size_t>(set->which);
  const auto* first = std::ranges::find(kCommandTypes, body.index(), &CommandType::alternative);
  return first[within].name;
}

Result<CommandInstance> decode_command(std::string_view document, std::size_t max_bytes) {
  return parse_xml(document, {.max_bytes = max_bytes}).and_then(read_command_instance);
}

Result<Program> decode_program(std::string_view document, std::size_t max_bytes) {
  return parse_xml(document, {.max_bytes = max_bytes}).and_then(read_program);
}

std::string encode_command(const CommandInstance& instance) {
  XmlWriter out;
  write_command_instance(out, instance);
  return std::move(out).document();
}

std::string encode_program(const Program& program) {
  XmlWriter out;
  write_program(out, program);
  return std::move(out).document();
}

Result<CommandInstance> read_command_instance(const XmlNode& root) {
  if (root.name != kCommandRoot) return wrong_root(root, kCommandRoot);
  const XmlNode* node = root.child("CRCLCommand");
  ErrorSlot slot;
  const Fields fields(root, slot);
  if (node == nullptr) {
    fields.fail("CRCLCommand", "", "missing", ErrorKind::kMalformed);
    return tl::unexpected<Error>(*slot);
  }
  CommandInstance instance;
  instance.command = read_command(*node, node->type, slot);
  instance.name = fields.optional_text("Name");
  instance.program_file = fields.optional_text("ProgramFile");
  instance.program_index = read_hint(root, "ProgramIndex");
  instance.program_length = read_hint(root, "ProgramLength");
  if (slot) return tl::unexpected<Error>(std::move(*slot));
  return instance;
}

Result<Program> read_program(const XmlNode& root) {
  if (root.name != kProgramRoot) return wrong_root(root, kProgramRoot);
  Program program;
  ErrorSlot slot;
  program.name = Fields(root, slot).optional_text("Name");
  for (const XmlNode& node : root.children) {
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

void write_command_instance(ElementWriter& out, const CommandInstance& instance) {
  out.open(kCommandRoot);
  write_optional(out, "Name", instance.name);
  out.open("CRCLCommand", type_name(instance.command.body));
  write_command(out, instance.command);
  out.close("CRCLCommand");
  write_optional(out, "ProgramFile", instance.program_file);
  write_optional(out, "ProgramIndex", instance.program_index);
  write_optional(out, "ProgramLength", instance.program_length);
  out.close(kCommandRoot);
}

void write_program(ElementWriter& out, const Program& program) {
  out.open(kProgramRoot);
  write_optional(out, "Name", program.name);
  for (const Command& command : program.commands) {
    std::string_view element = "MiddleCommand";
    if (std::holds_alternative<InitCanon>(command.body)) element = "InitCanon";
    if (std::holds_alternative<EndCanon>(command.body)) element = "EndCanon";
    if (element == "MiddleCommand") {
      out.open(element, type_name(command.body));
    } else {
      out.open(element);
    }
    write_command(out, command);
    out.close(element);
  }
  out.close(kProgramRoot);
}

}  // namespace aprsim::crcl
