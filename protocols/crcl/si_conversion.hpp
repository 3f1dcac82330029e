#pragma once

#include <optional>
#include <vector>

#include "crcl/commands.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "world/api/error.hpp"
#include "world/api/robot_command.hpp"

/// CRCL commands, in the units of a connection, as commands to a robot, in SI.
namespace aprsim::protocols {

/// The same tolerance in m and rad.
[[nodiscard]] crcl::PoseTolerance in_si(const crcl::PoseTolerance& tolerance,
                                        const crcl::Units& units);

/// Poses are those of the tool in the robot's reference frame. What a pose sets for itself goes
/// with it; errors name the element, the value and its limit.
/// `end_si`, `intermediate_si`: for the last pose and the others without a tolerance of their own.
[[nodiscard]] Result<api::MoveTo> to_action(const crcl::MoveTo& move,
                                            const ConnectionSettings& units,
                                            const std::optional<crcl::PoseTolerance>& end_si);
[[nodiscard]] Result<api::MoveThroughTo> to_action(
    const crcl::MoveThroughTo& move, const ConnectionSettings& units,
    const std::optional<crcl::PoseTolerance>& intermediate_si,
    const std::optional<crcl::PoseTolerance>& end_si);
[[nodiscard]] Result<api::MoveScrew> to_action(const crcl::MoveScrew& screw,
                                               const ConnectionSettings& units);

/// Errors name joint, value and limit: a joint outside 1 to `joint_count`, a speed, acceleration or
/// torque that is not above 0, a tolerance below 0. `default_si`: for joints without a tolerance of
/// their own.
[[nodiscard]] Result<api::MoveJoints> to_action(
    const crcl::ActuateJoints& command, const ConnectionSettings& units, int joint_count,
    const std::vector<crcl::JointTolerance>& default_si);

/// Refuses a tolerance below 0.
[[nodiscard]] Result<void> check(const crcl::PoseTolerance& tolerance);
[[nodiscard]] Result<void> check(const std::vector<crcl::JointTolerance>& tolerances,
                                 int joint_count);

/// Clamped to 0..1.
[[nodiscard]] api::SetGripper to_action(const crcl::SetEndEffector& set);

[[nodiscard]] Result<api::Dwell> to_action(const crcl::Dwell& dwell);

[[nodiscard]] api::StopMotion to_action(const crcl::StopMotion& stop);

/// A fraction above 1 becomes 1; what is not above 0 is an error.
[[nodiscard]] Result<api::SetMotionLimit> to_action(crcl::RateKind which, const crcl::Rate& rate,
                                                    const ConnectionSettings& units);

}  // namespace aprsim::protocols
