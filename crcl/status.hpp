#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "crcl/sensor_status.hpp"
#include "crcl/units.hpp"
#include "crcl/values.hpp"

/// CRCLStatus.xsd as C++ values, numbers in the units of the connection. Each struct is the schema
/// type of the same name with "Type" appended.
namespace aprsim::crcl {

enum class CommandState { kDone, kError, kWorking, kReady };

struct CommandStatus {
  std::optional<std::string> name;
  std::int64_t command_id = 0;
  std::int64_t status_id = 0;
  CommandState state = CommandState::kReady;
  std::optional<std::string> description;  ///< StateDescription
  std::optional<std::string> program_file;
  std::optional<int> program_index, program_length;
  std::optional<int> override_percent;
  bool operator==(const CommandStatus&) const = default;
};

struct JointStatus {
  int joint = 0;  ///< 1-based
  std::optional<double> position, torque, velocity;
  bool operator==(const JointStatus&) const = default;
};

struct Twist {
  Vector linear, angular;
  bool operator==(const Twist&) const = default;
};
struct Wrench {
  Vector force, moment;
  bool operator==(const Wrench&) const = default;
};
struct PoseStatus {
  Pose pose;
  std::optional<Twist> twist;
  std::optional<Wrench> wrench;
  std::optional<std::string> configuration;
  bool operator==(const PoseStatus&) const = default;
};

struct ParallelGripper {
  double separation = 0;  ///< length units
  bool operator==(const ParallelGripper&) const = default;
};
struct ThreeFingerGripper {
  std::array<std::optional<double>, 3> position;  ///< fraction
  std::array<std::optional<double>, 3> force;
  bool operator==(const ThreeFingerGripper&) const = default;
};
struct VacuumGripper {
  bool powered = false;
  bool operator==(const VacuumGripper&) const = default;
};
struct GripperStatus {
  std::string name;  ///< an NMTOKEN: letters, digits, . - _ :
  std::vector<ParameterSetting> options;
  /// The Java client fails on a GripperStatus without it.
  std::optional<bool> holding;
  std::variant<ParallelGripper, ThreeFingerGripper, VacuumGripper> kind;
  bool operator==(const GripperStatus&) const = default;
};

struct JointLimits {
  int joint = 0;  ///< 1-based
  std::optional<double> min_position, max_position, max_torque, max_velocity;
  bool operator==(const JointLimits&) const = default;
};

struct SettingsStatus {
  std::optional<AngleUnit> angle_unit;
  std::vector<ParameterSetting> end_effector_parameters;
  std::optional<double> end_effector;
  std::optional<ForceUnit> force_unit;
  std::vector<JointLimits> joint_limits;
  std::optional<PoseTolerance> intermediate_tolerance;
  std::optional<LengthUnit> length_unit;
  std::optional<Vector> max_cartesian, min_cartesian;
  std::optional<bool> coordinated;
  std::optional<PoseTolerance> end_tolerance;
  std::vector<ParameterSetting> robot_parameters;
  std::optional<Rate> rot_accel, rot_speed;
  std::optional<TorqueUnit> torque_unit;
  std::optional<Rate> trans_accel, trans_speed;
  std::vector<JointTolerance> joint_tolerances;
  bool operator==(const SettingsStatus&) const = default;
};

/// The root CRCLStatus.
struct Status {
  std::optional<std::string> name;
  CommandStatus command;
  std::vector<JointStatus> joints;  ///< JointStatuses is left out when empty
  std::optional<PoseStatus> pose;
  std::optional<GripperStatus> gripper;
  std::optional<SettingsStatus> settings;
  std::optional<SensorStatuses> sensors;
  std::optional<GuardsStatuses> guards;
  bool operator==(const Status&) const = default;
};

/// The schema's name, e.g. "CRCL_Done".
[[nodiscard]] std::string_view name_of(CommandState state);

}  // namespace aprsim::crcl
