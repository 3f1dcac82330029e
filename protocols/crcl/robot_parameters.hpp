#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "crcl/commands.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/sensor_board.hpp"
#include "world/api/commands/robot_command.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/base/result.hpp"

namespace aprsim::crcl_server {

/// Robot parameters with an effect or a reading.
namespace parameter {
inline constexpr std::string_view kSpeedOverride = "speed_override", kPlanning = "planning";
inline constexpr std::string_view kSimulatedTime = "simulated_time";
inline constexpr std::string_view kProtectiveStop = "protective_stop", kDrives = "drives";
}  // namespace parameter

/// Parameters, sensors, gripper reports and motion coordination of one robot, shared by all its
/// connections. Settings of clients are kept over InitCanon.
///
/// End effector parameters with an effect: `force`, of each finger, in the connection's force unit;
/// `pressure`, the same as a fraction of the supply's. Robot parameters with an effect:
/// `speed_override`, in percent; `planning` (direct, check, avoid). Robot parameters that can be
/// read when their report is enabled: `simulated_time` [s], `protective_stop`, `drives` (on, off).
/// The names of kExtraReports stand for parts of a connection's statuses. Any other parameter is
/// kept and reported as it was set.
class RobotParameters {
 public:
  /// The action to submit to the robot, if any.
  using Outcome = Result<std::optional<api::RobotAction>>;

  /// `tools` that the robot may have, `beams` of the cell's light curtain, 0 = none.
  RobotParameters(const api::RobotDescription& robot, std::span<const api::ToolDescription> tools,
                  const JointMap& joints, int beams);

  [[nodiscard]] Outcome apply(const crcl::SetEndEffectorParameters& command,
                              ConnectionSettings& settings);
  [[nodiscard]] Outcome apply(const crcl::SetRobotParameters& command,
                              ConnectionSettings& settings);
  [[nodiscard]] Outcome apply(const crcl::EnableGripper& command, ConnectionSettings& settings);
  [[nodiscard]] Outcome apply(const crcl::DisableGripper& command, ConnectionSettings& settings);
  [[nodiscard]] Outcome apply(const crcl::EnableSensor& command, ConnectionSettings& settings);
  [[nodiscard]] Outcome apply(const crcl::DisableSensor& command, ConnectionSettings& settings);
  [[nodiscard]] Outcome apply(const crcl::EnableRobotParameterStatus& command,
                              ConnectionSettings& settings);
  [[nodiscard]] Outcome apply(const crcl::DisableRobotParameterStatus& command,
                              ConnectionSettings& settings);
  [[nodiscard]] Outcome apply(const crcl::SetMotionCoordination& command,
                              ConnectionSettings& settings);

  /// The robot has been built anew, with its own parameters. Sensors stay enabled.
  void forget();

  [[nodiscard]] const SensorBoard& sensors() const { return sensors_; }
  [[nodiscard]] std::optional<bool> coordinated() const { return coordinated_; }
  /// The one by which it was enabled, else the first of its names.
  [[nodiscard]] const std::string& gripper_name() const { return gripper_name_; }
  /// A listed tool's own, unless a name of the robot's gripper has been enabled.
  [[nodiscard]] std::string name_of(const api::ToolDescription& tool) const;
  [[nodiscard]] const std::vector<crcl::ParameterSetting>& gripper_options() const {
    return gripper_options_;
  }
  /// As set, by name.
  [[nodiscard]] const std::map<std::string, std::string>& end_effector() const {
    return end_effector_;
  }
  [[nodiscard]] const std::map<std::string, std::string>& robot() const { return robot_; }
  /// Robot parameters whose report is disabled though they are set, and enabled though they are
  /// not.
  [[nodiscard]] const std::set<std::string>& hidden() const { return hidden_; }
  [[nodiscard]] const std::set<std::string>& shown() const { return shown_; }

 private:
  [[nodiscard]] Result<void> check_gripper(const std::string& name) const;

  std::vector<std::string> gripper_names_, tool_names_;
  std::string gripper_name_;  // one of them
  bool named_ = false;        // by EnableGripper, by a name that is no tool's
  double max_grip_force_n_;
  SensorBoard sensors_;
  std::optional<bool> coordinated_;
  std::vector<crcl::ParameterSetting> gripper_options_;
  std::map<std::string, std::string> end_effector_, robot_;  // as set
  std::set<std::string> hidden_, shown_;                     // by Disable and Enable
};

}  // namespace aprsim::crcl_server
