#pragma once

#include <vector>

#include "crcl/commands.hpp"
#include "protocols/crcl/report_settings.hpp"
#include "world/api/command.hpp"
#include "world/api/error.hpp"

/// CRCL commands, in the units of a connection, as commands to a robot, in SI.
namespace aprsim::protocols {

/// The tool pose in the robot's reference frame.
[[nodiscard]] Result<api::MoveTo> to_action(const crcl::MoveTo& move, const ReportSettings& units);

/// Errors name joint, value and limit: a joint outside 1 to `joint_count`, a speed or acceleration
/// that is not above 0, the force/torque form.
[[nodiscard]] Result<api::MoveJoints> to_action(const crcl::ActuateJoints& command,
                                                const ReportSettings& units, int joint_count);

/// Clamped to 0..1.
[[nodiscard]] api::SetGripper to_action(const crcl::SetEndEffector& set);

[[nodiscard]] Result<api::Dwell> to_action(const crcl::Dwell& dwell);

[[nodiscard]] api::StopMotion to_action(const crcl::StopMotion& stop);

/// A fraction above 1 becomes 1; what is not above 0 is an error.
[[nodiscard]] Result<api::SetMotionLimit> to_action(crcl::RateKind which, const crcl::Rate& rate,
                                                    const ReportSettings& units);

/// The limits that a pose carries for its own move only.
[[nodiscard]] Result<std::vector<api::SetMotionLimit>> overrides_of(const crcl::MoveTo& move,
                                                                    const ReportSettings& units);

}  // namespace aprsim::protocols
