#pragma once

#include <optional>
#include <vector>

#include "crcl/status.hpp"
#include "protocols/crcl/command_submitter.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/robot_parameters.hpp"
#include "protocols/crcl/target_limits.hpp"
#include "world/api/snapshot.hpp"

/// The sections of a status, from one snapshot, in the units of one connection.
namespace aprsim::protocols {

/// Only joints of which the connection wants anything.
[[nodiscard]] std::vector<crcl::JointStatus> joint_statuses(const api::RobotSnapshot& robot,
                                                            int joint_count,
                                                            const ConnectionSettings& settings);
/// Axes exactly as they are, the point in length units.
[[nodiscard]] crcl::Pose pose_in(const Pose& pose, crcl::LengthUnit unit);
/// Pose, twist and contact wrench of the tool in the robot's frame, and the arm's branch.
[[nodiscard]] crcl::PoseStatus pose_status(const api::RobotSnapshot& robot, int joint_count,
                                           const ConnectionSettings& settings);
[[nodiscard]] crcl::GripperStatus gripper_status(const api::RobotSnapshot& robot,
                                                 const RobotParameters& services,
                                                 const ConnectionSettings& settings);

/// Tolerances that clients have set, lengths in m, angles in rad (joints too).
struct Tolerances {
  std::optional<crcl::PoseTolerance> end, intermediate;
  std::vector<crcl::JointTolerance> joints;
};

/// What a settings report is made of.
struct SettingsSources {
  const api::Snapshot& snapshot;
  int robot;
  const CommandSubmitter& commander;
  const RobotParameters& services;
  const Tolerances& tolerances;
  const CartesianLimits& limits;
};
[[nodiscard]] crcl::SettingsStatus settings_status(const SettingsSources& sources,
                                                   const ConnectionSettings& settings);

}  // namespace aprsim::protocols
