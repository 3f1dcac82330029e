#include <chrono>
#include <cmath>
#include <cstdint>

#include "protocols/crcl/command_lifecycle.hpp"
#include "protocols/crcl/status_builder.hpp"

namespace aprsim::protocols {

crcl::CommandStatus CommandLifecycle::command_status() {
  crcl::CommandStatus status = latest_;
  if (error_) {
    status.state = crcl::CommandState::kError;
  } else if ((program_ && in_program_) || progress_ == Progress::kWaiting) {
    status.state = crcl::CommandState::kWorking;
  } else {
    status.state =
        progress_ == Progress::kDone ? crcl::CommandState::kDone : crcl::CommandState::kReady;
  }
  return status;
}

crcl::Status CommandLifecycle::status(const ConnectionSettings& settings) {
  if (program_) advance();
  const api::SnapshotPtr snapshot = source_.latest();
  refresh(*snapshot);
  ++latest_.status_id;
  const api::RobotSnapshot& robot = snapshot->robots[static_cast<std::size_t>(robot_)];
  const int joint_count = static_cast<int>(description().joints.size());
  const crcl::ConfigureStatusReport& wanted = settings.sections();
  crcl::Status status;
  status.command = command_status();
  status.command.override_percent = static_cast<int>(std::lround(robot.override_fraction * 100));
  if (wanted.joints) status.joints = joint_statuses(robot, joint_count, settings);
  if (wanted.pose) status.pose = pose_status(robot, joint_count, settings);
  if (wanted.gripper && robot.tool_mounted) {
    status.gripper = gripper_status(robot, services_, settings);
  }
  if (wanted.settings) {
    status.settings =
        settings_status({*snapshot, robot_, commander_, services_, tolerances_, limits_}, settings);
  }
  if (wanted.sensors) {
    status.sensors = services_.sensors().statuses(
        *snapshot, static_cast<std::size_t>(robot_),
        static_cast<std::int32_t>(snapshot->step & 0x7FFFFFFF),
        options_.start_ms + snapshot->time / std::chrono::milliseconds(1), settings.units());
  }
  if (settings.wants_guards(guards_.used())) {
    status.guards = guards_.statuses(robot.guards, options_.start_ms, settings.units());
  }
  return status;
}

}  // namespace aprsim::protocols
