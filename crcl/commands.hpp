#pragma once

#include <string>
#include <variant>
#include <vector>

#include "crcl/motion_commands.hpp"
#include "crcl/service_commands.hpp"
#include "crcl/units.hpp"
#include "crcl/values.hpp"

/// The commands of CRCLCommands.xsd as C++ values, numbers in the units of the connection.
/// Each struct is the schema type of the same name with "Type" appended, unless it says otherwise.
namespace aprsim::crcl {

struct InitCanon {
  bool operator==(const InitCanon&) const = default;
};
struct EndCanon {
  bool operator==(const EndCanon&) const = default;
};
struct GetStatus {
  bool operator==(const GetStatus&) const = default;
};

struct SetEndEffector {
  double setting = 0;  ///< 0 closed .. 1 open; out-of-range values are kept as sent
  bool operator==(const SetEndEffector&) const = default;
};
struct OpenToolChanger {
  bool operator==(const OpenToolChanger&) const = default;
};
struct CloseToolChanger {
  bool operator==(const CloseToolChanger&) const = default;
};
struct Dwell {
  double seconds = 0;
  bool operator==(const Dwell&) const = default;
};
struct Message {
  std::string text;
  bool operator==(const Message&) const = default;
};

/// SetLengthUnitsType, SetAngleUnitsType, SetForceUnitsType, SetTorqueUnitsType.
struct SetUnits {
  std::variant<LengthUnit, AngleUnit, ForceUnit, TorqueUnit> unit;
  bool operator==(const SetUnits&) const = default;
};
/// SetTransSpeedType, SetTransAccelType, SetRotSpeedType, SetRotAccelType.
struct SetRate {
  RateKind which = RateKind::kTransSpeed;
  Rate rate;
  bool operator==(const SetRate&) const = default;
};
struct SetEndPoseTolerance {
  PoseTolerance tolerance;
  bool operator==(const SetEndPoseTolerance&) const = default;
};
struct SetIntermediatePoseTolerance {
  PoseTolerance tolerance;
  bool operator==(const SetIntermediatePoseTolerance&) const = default;
};
/// SetDefaultJointPositonsTolerancesType (the schema's spelling).
struct SetDefaultJointTolerances {
  std::vector<JointTolerance> tolerances;
  bool operator==(const SetDefaultJointTolerances&) const = default;
};

struct JointReport {
  int joint = 0;  ///< 1-based
  bool position = false, torque = false, velocity = false;
  bool operator==(const JointReport&) const = default;
};
struct ConfigureJointReports {
  bool reset_all = false;
  std::vector<JointReport> reports;
  bool operator==(const ConfigureJointReports&) const = default;
};
struct ConfigureStatusReport {
  bool joints = false, pose = false, gripper = false, settings = false, sensors = false,
       guards = false;
  bool operator==(const ConfigureStatusReport&) const = default;
};

/// Loops exist in program files only; a client expands them before it sends commands.
struct LoopBlockStart {
  std::string loop;
  bool operator==(const LoopBlockStart&) const = default;
};
struct LoopBlockEnd {
  std::string loop;
  int max_count = 0;
  bool operator==(const LoopBlockEnd&) const = default;
};

using AnyCommand =
    std::variant<InitCanon, EndCanon, GetStatus, StopMotion, MoveTo, MoveThroughTo, MoveScrew,
                 ActuateJoints, SetEndEffector, OpenToolChanger, CloseToolChanger, Dwell, Message,
                 SetUnits, SetRate, SetEndPoseTolerance, SetIntermediatePoseTolerance,
                 SetDefaultJointTolerances, ConfigureJointReports, ConfigureStatusReport,
                 LoopBlockStart, LoopBlockEnd, SetEndEffectorParameters, SetRobotParameters,
                 EnableGripper, DisableGripper, EnableSensor, DisableSensor,
                 EnableRobotParameterStatus, DisableRobotParameterStatus, SetMotionCoordination,
                 RunProgram>;

/// One of the commands. Copied, compared and destroyed out of line: code for so many alternatives
/// in every file that does so would cost much time to compile.
struct CommandBody : AnyCommand {
  using AnyCommand::AnyCommand;
  using AnyCommand::operator=;
  CommandBody();
  CommandBody(const CommandBody& other);
  CommandBody(CommandBody&& other) noexcept;
  CommandBody& operator=(const CommandBody& other);
  CommandBody& operator=(CommandBody&& other) noexcept;
  ~CommandBody();
  bool operator==(const CommandBody& other) const;
};

/// Whether the command is of one of these types.
template <typename... Commands>
[[nodiscard]] bool holds_any_of(const CommandBody& body) {
  return (std::holds_alternative<Commands>(body) || ...);
}

}  // namespace aprsim::crcl
