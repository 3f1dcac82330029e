#pragma once

#include <string>
#include <vector>

#include "crcl/values.hpp"

/// The commands of CRCLCommands.xsd without motion: parameters, sensors, grippers, programs.
/// Each struct is the schema type of the same name with "Type" appended.
namespace aprsim::crcl {

struct SetEndEffectorParameters {
  std::vector<ParameterSetting> settings;  ///< at least one
  bool operator==(const SetEndEffectorParameters&) const = default;
};
struct SetRobotParameters {
  std::vector<ParameterSetting> settings;  ///< at least one
  bool operator==(const SetRobotParameters&) const = default;
};

struct EnableGripper {
  std::string gripper;  ///< GripperName
  std::vector<ParameterSetting> options;
  bool operator==(const EnableGripper&) const = default;
};
struct DisableGripper {
  std::string gripper;  ///< GripperName
  bool operator==(const DisableGripper&) const = default;
};

struct EnableSensor {
  std::string sensor_id;
  std::vector<ParameterSetting> options;
  bool operator==(const EnableSensor&) const = default;
};
struct DisableSensor {
  std::string sensor_id;
  bool operator==(const DisableSensor&) const = default;
};

struct EnableRobotParameterStatus {
  std::string parameter;  ///< RobotParameterName
  bool operator==(const EnableRobotParameterStatus&) const = default;
};
struct DisableRobotParameterStatus {
  std::string parameter;  ///< RobotParameterName
  bool operator==(const DisableRobotParameterStatus&) const = default;
};

struct SetMotionCoordination {
  bool coordinated = false;
  bool operator==(const SetMotionCoordination&) const = default;
};

struct RunProgram {
  std::string text;  ///< ProgramText, as it stands
  bool operator==(const RunProgram&) const = default;
};

}  // namespace aprsim::crcl
