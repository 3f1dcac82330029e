#include <array>
#include <string>

#include "crcl/encoder.hpp"
#include "crcl/sensor_codec.hpp"
#include "crcl/service_writer.hpp"
#include "crcl/value_writer.hpp"

namespace aprsim::crcl {
namespace {

void write_rate(XmlWriter& out, const std::string& base, const Rate& rate) {
  out.open(base, base + (rate.relative ? "RelativeType" : "AbsoluteType"));
  out.number(rate.relative ? "Fraction" : "Setting", rate.value);
  out.close(base);
}

void write_rate(XmlWriter& out, const std::string& base, const std::optional<Rate>& rate) {
  if (rate) write_rate(out, base, *rate);
}

void write_pose_settings(XmlWriter& out, const PoseSettings& settings) {
  out.flag("Coordinated", settings.coordinated);
  write_rate(out, "TransSpeed", settings.trans_speed);
  write_rate(out, "RotSpeed", settings.rot_speed);
  write_rate(out, "TransAccel", settings.trans_accel);
  write_rate(out, "RotAccel", settings.rot_accel);
  if (settings.tolerance) write_tolerance(out, "Tolerance", *settings.tolerance);
}

void write_waypoint(XmlWriter& out, std::string_view name, const Pose& pose,
                    const std::optional<PoseSettings>& settings) {
  if (settings) {
    out.open(name, "PoseAndSetType");
  } else {
    out.open(name);
  }
  write_pose_elements(out, pose);
  if (settings) write_pose_settings(out, *settings);
  out.close(name);
}

void write_joint_details(XmlWriter& out, const JointSpeedAccel& details) {
  out.open("JointDetails", "JointSpeedAccelType");
  write_optional(out, "JointSpeed", details.speed);
  write_optional(out, "JointAccel", details.accel);
  out.close("JointDetails");
}

void write_joint_details(XmlWriter& out, const JointForceTorque& details) {
  out.open("JointDetails", "JointForceTorqueType");
  write_optional(out, "Setting", details.setting);
  write_optional(out, "ChangeRate", details.change_rate);
  out.close("JointDetails");
}

// Writes what a command has beyond CommandID and guards.
struct BodyWriter {
  XmlWriter& out;

  void operator()(const InitCanon&) const {}
  void operator()(const EndCanon&) const {}
  void operator()(const GetStatus&) const {}

  void operator()(const StopMotion& stop) const {
    constexpr std::array<const char*, 3> kNames{"Immediate", "Fast", "Normal"};
    out.text("StopCondition", kNames[static_cast<std::size_t>(stop.condition)]);
  }

  void operator()(const MoveTo& move) const {
    out.flag("MoveStraight", move.straight);
    write_waypoint(out, "EndPosition", move.end, move.settings);
  }

  void operator()(const MoveThroughTo& move) const {
    out.flag("MoveStraight", move.straight);
    for (const Waypoint& point : move.waypoints) {
      write_waypoint(out, "Waypoint", point.pose, point.settings);
    }
    out.integer("NumPositions", static_cast<int>(move.waypoints.size()));
  }

  void operator()(const MoveScrew& screw) const {
    if (screw.start) {
      write_waypoint(out, "StartPosition", screw.start->pose, screw.start->settings);
    }
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
    constexpr std::array<const char*, 4> kBases{"TransSpeed", "TransAccel", "RotSpeed", "RotAccel"};
    write_rate(out, kBases[static_cast<std::size_t>(set.which)], set.rate);
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
  template <typename Service>
  void operator()(const Service& command) const {
    write_body(out, command);
  }
};

}  // namespace

std::string encode_command(const CommandInstance& instance) {
  XmlWriter out;
  out.open("CRCLCommandInstance");
  write_optional(out, "Name", instance.name);
  out.open("CRCLCommand", type_name(instance.command.body));
  write_optional(out, "Name", instance.command.name);
  out.integer("CommandID", instance.command.id);
  for (const Guard& guard : instance.command.guards) write_guard(out, guard);
  std::visit(BodyWriter{out}, instance.command.body);
  out.close("CRCLCommand");
  write_optional(out, "ProgramFile", instance.program_file);
  write_optional(out, "ProgramIndex", instance.program_index);
  write_optional(out, "ProgramLength", instance.program_length);
  out.close("CRCLCommandInstance");
  return out.take();
}

}  // namespace aprsim::crcl
