#include "crcl/commands.hpp"

#include <array>
#include <cstddef>

namespace aprsim::crcl {
namespace {

template <typename... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <typename... F>
Overloaded(F...) -> Overloaded<F...>;

constexpr std::array<std::string_view, 4> kUnitTypes{"SetLengthUnitsType", "SetAngleUnitsType",
                                                     "SetForceUnitsType", "SetTorqueUnitsType"};
constexpr std::array<std::string_view, 4> kRateTypes{"SetTransSpeedType", "SetTransAccelType",
                                                     "SetRotSpeedType", "SetRotAccelType"};

}  // namespace

std::string_view type_name(const CommandBody& body) {
  using View = std::string_view;
  return std::visit(
      Overloaded{
          [](const InitCanon&) -> View { return "InitCanonType"; },
          [](const EndCanon&) -> View { return "EndCanonType"; },
          [](const GetStatus&) -> View { return "GetStatusType"; },
          [](const StopMotion&) -> View { return "StopMotionType"; },
          [](const MoveTo&) -> View { return "MoveToType"; },
          [](const MoveThroughTo&) -> View { return "MoveThroughToType"; },
          [](const MoveScrew&) -> View { return "MoveScrewType"; },
          [](const ActuateJoints&) -> View { return "ActuateJointsType"; },
          [](const SetEndEffector&) -> View { return "SetEndEffectorType"; },
          [](const OpenToolChanger&) -> View { return "OpenToolChangerType"; },
          [](const CloseToolChanger&) -> View { return "CloseToolChangerType"; },
          [](const Dwell&) -> View { return "DwellType"; },
          [](const Message&) -> View { return "MessageType"; },
          [](const SetUnits& set) -> View { return kUnitTypes[set.unit.index()]; },
          [](const SetRate& set) -> View {
            return kRateTypes[static_cast<std::size_t>(set.which)];
          },
          [](const SetEndPoseTolerance&) -> View { return "SetEndPoseToleranceType"; },
          [](const SetIntermediatePoseTolerance&) -> View {
            return "SetIntermediatePoseToleranceType";
          },
          [](const SetDefaultJointTolerances&) -> View {
            return "SetDefaultJointPositonsTolerancesType";
          },
          [](const ConfigureJointReports&) -> View { return "ConfigureJointReportsType"; },
          [](const ConfigureStatusReport&) -> View { return "ConfigureStatusReportType"; },
          [](const LoopBlockStart&) -> View { return "LoopBlockStartType"; },
          [](const LoopBlockEnd&) -> View { return "LoopBlockEndType"; },
          [](const SetEndEffectorParameters&) -> View { return "SetEndEffectorParametersType"; },
          [](const SetRobotParameters&) -> View { return "SetRobotParametersType"; },
          [](const EnableGripper&) -> View { return "EnableGripperType"; },
          [](const DisableGripper&) -> View { return "DisableGripperType"; },
          [](const EnableSensor&) -> View { return "EnableSensorType"; },
          [](const DisableSensor&) -> View { return "DisableSensorType"; },
          [](const EnableRobotParameterStatus&) -> View {
            return "EnableRobotParameterStatusType";
          },
          [](const DisableRobotParameterStatus&) -> View {
            return "DisableRobotParameterStatusType";
          },
          [](const SetMotionCoordination&) -> View { return "SetMotionCoordinationType"; },
          [](const RunProgram&) -> View { return "RunProgramType"; },
      },
      body);
}

}  // namespace aprsim::crcl
