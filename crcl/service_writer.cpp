#include "crcl/service_writer.hpp"

#include "crcl/value_writer.hpp"

namespace aprsim::crcl {

void write_body(XmlWriter& out, const SetEndEffectorParameters& command) {
  write_parameters(out, "ParameterSetting", command.settings);
}

void write_body(XmlWriter& out, const SetRobotParameters& command) {
  write_parameters(out, "ParameterSetting", command.settings);
}

void write_body(XmlWriter& out, const EnableGripper& command) {
  out.text("GripperName", command.gripper);
  write_parameters(out, "GripperOption", command.options);
}

void write_body(XmlWriter& out, const DisableGripper& command) {
  out.text("GripperName", command.gripper);
}

void write_body(XmlWriter& out, const EnableSensor& command) {
  out.text("SensorID", command.sensor_id);
  write_parameters(out, "SensorOption", command.options);
}

void write_body(XmlWriter& out, const DisableSensor& command) {
  out.text("SensorID", command.sensor_id);
}

void write_body(XmlWriter& out, const EnableRobotParameterStatus& command) {
  out.text("RobotParameterName", command.parameter);
}

void write_body(XmlWriter& out, const DisableRobotParameterStatus& command) {
  out.text("RobotParameterName", command.parameter);
}

void write_body(XmlWriter& out, const SetMotionCoordination& command) {
  out.flag("Coordinated", command.coordinated);
}

void write_body(XmlWriter& out, const RunProgram& command) {
  out.text("ProgramText", command.text);
}

}  // namespace aprsim::crcl
