#pragma once

#include <vector>

#include "crcl/status.hpp"
#include "protocols/crcl/report_settings.hpp"
#include "protocols/crcl/robot_commander.hpp"
#include "protocols/crcl/robot_link.hpp"
#include "world/api/snapshot.hpp"

/// The sections of a status, from one snapshot, in the units of one connection.
namespace aprsim::protocols {

/// Only joints of which the connection wants anything.
[[nodiscard]] std::vector<crcl::JointStatus> joint_statuses(const api::RobotSnapshot& robot,
                                                            int joint_count,
                                                            const ReportSettings& settings);
[[nodiscard]] crcl::PoseStatus pose_status(const api::RobotSnapshot& robot,
                                           const ReportSettings& settings);
[[nodiscard]] crcl::GripperStatus gripper_status(const api::RobotSnapshot& robot,
                                                 const api::RobotDescription& description,
                                                 const ReportSettings& settings);
[[nodiscard]] crcl::SettingsStatus settings_status(const api::Snapshot& snapshot, int robot,
                                                   const RobotCommander& commander,
                                                   const RobotLink::Tolerances& tolerances,
                                                   const ReportSettings& settings);

}  // namespace aprsim::protocols
