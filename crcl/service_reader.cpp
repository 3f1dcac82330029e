#include <string>

#include "crcl/command_reader.hpp"
#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

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

constexpr CommandReader kServiceReaders[] = {
    {"SetEndEffectorParametersType",
     [](const Fields& f) -> CommandBody { return SetEndEffectorParameters{read_parameters(f)}; }},
    {"SetRobotParametersType",
     [](const Fields& f) -> CommandBody { return SetRobotParameters{read_parameters(f)}; }},
    {"EnableGripperType",
     [](const Fields& f) -> CommandBody {
       return EnableGripper{read_token(f, "GripperName"), read_parameters(f, "GripperOption")};
     }},
    {"DisableGripperType",
     [](const Fields& f) -> CommandBody { return DisableGripper{read_token(f, "GripperName")}; }},
    {"EnableSensorType",
     [](const Fields& f) -> CommandBody {
       return EnableSensor{read_token(f, "SensorID"), read_parameters(f, "SensorOption")};
     }},
    {"DisableSensorType",
     [](const Fields& f) -> CommandBody { return DisableSensor{read_token(f, "SensorID")}; }},
    {"EnableRobotParameterStatusType",
     [](const Fields& f) -> CommandBody {
       return EnableRobotParameterStatus{read_token(f, "RobotParameterName")};
     }},
    {"DisableRobotParameterStatusType",
     [](const Fields& f) -> CommandBody {
       return DisableRobotParameterStatus{read_token(f, "RobotParameterName")};
     }},
    {"SetMotionCoordinationType",
     [](const Fields& f) -> CommandBody { return SetMotionCoordination{f.flag("Coordinated")}; }},
    {"RunProgramType",
     [](const Fields& f) -> CommandBody { return RunProgram{f.text("ProgramText")}; }},
};

}  // namespace

std::span<const CommandReader> service_readers() { return kServiceReaders; }

}  // namespace aprsim::crcl
