#pragma once

#include "crcl/service_commands.hpp"
#include "crcl/xml_writer.hpp"

/// What a command has beyond CommandID and guards, in schema order.
namespace aprsim::crcl {

void write_body(XmlWriter& out, const SetEndEffectorParameters& command);
void write_body(XmlWriter& out, const SetRobotParameters& command);
void write_body(XmlWriter& out, const EnableGripper& command);
void write_body(XmlWriter& out, const DisableGripper& command);
void write_body(XmlWriter& out, const EnableSensor& command);
void write_body(XmlWriter& out, const DisableSensor& command);
void write_body(XmlWriter& out, const EnableRobotParameterStatus& command);
void write_body(XmlWriter& out, const DisableRobotParameterStatus& command);
void write_body(XmlWriter& out, const SetMotionCoordination& command);
void write_body(XmlWriter& out, const RunProgram& command);

}  // namespace aprsim::crcl
