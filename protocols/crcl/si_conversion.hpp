#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "crcl/commands.hpp"
#include "crcl/guard.hpp"
#include "crcl/units.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/joint_map.hpp"
#include "protocols/crcl/sensor_board.hpp"
#include "world/api/commands/robot_command.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/base/result.hpp"

/// CRCL commands, in the units of a connection, as commands to a robot, in SI.
namespace aprsim::crcl_server {

/// Tolerances that clients have set, in SI.
struct Tolerances {
  std::optional<api::PoseTolerance> end, intermediate;
  std::vector<crcl::JointTolerance> joints;  ///< of the joints as CRCL counts them [rad]
};

/// The same tolerance in m and rad.
[[nodiscard]] api::PoseTolerance in_si(const crcl::PoseTolerance& tolerance,
                                       const crcl::Units& units);

/// Poses are those of the tool in the robot's reference frame. A pose's own settings are kept;
/// `tolerances` are for poses and joints without their own. Errors name the element, the value and
/// its limit.
[[nodiscard]] Result<api::MoveTo> to_action(const crcl::MoveTo& move,
                                            const ConnectionSettings& units,
                                            const Tolerances& tolerances);
[[nodiscard]] Result<api::MoveThroughTo> to_action(const crcl::MoveThroughTo& move,
                                                   const ConnectionSettings& units,
                                                   const Tolerances& tolerances);
[[nodiscard]] Result<api::MoveScrew> to_action(const crcl::MoveScrew& screw,
                                               const ConnectionSettings& units);

/// Targets of joints as CRCL counts them; `joints` makes it a command for the robot. Errors
/// name joint, value and limit: a joint that `joints` does not have or that is named twice, a
/// speed, acceleration or torque that is not above 0, a tolerance below 0.
[[nodiscard]] Result<std::vector<WireTarget>> to_targets(const crcl::ActuateJoints& command,
                                                         const ConnectionSettings& units,
                                                         const JointMap& joints,
                                                         const Tolerances& tolerances);

/// Refuses a tolerance below 0 and a joint number below 1. Numbers beyond the robot's joints are
/// valid, as on NIST's servers: the APRS framework sends eight to every robot.
[[nodiscard]] Result<void> check(const crcl::PoseTolerance& tolerance);
[[nodiscard]] Result<void> check(const std::vector<crcl::JointTolerance>& tolerances);

/// Clamped to 0..1.
[[nodiscard]] api::SetGripper to_action(const crcl::SetEndEffector& set);

[[nodiscard]] Result<api::Dwell> to_action(const crcl::Dwell& dwell);

[[nodiscard]] api::StopMotion to_action(const crcl::StopMotion& stop);

/// A fraction above 1 becomes 1; 0 and less are errors.
[[nodiscard]] Result<api::SetMotionLimit> to_action(crcl::RateKind which, const crcl::Rate& rate,
                                                    const ConnectionSettings& units);

/// Errors: an unknown sensor or subfield, more than api::kMaxGuards, an increase or decrease that
/// is not above 0, a negative recheck time.
[[nodiscard]] Result<std::vector<api::Guard>> to_guards(const std::vector<crcl::Guard>& guards,
                                                        const SensorBoard& sensors,
                                                        const crcl::Units& units);

/// Guards of the robot's latest guarded command, for statuses in the units of any connection.
struct GuardedCommand {
  struct Entry {
    crcl::Guard guard;  ///< its limit in SI; without counts and readings
    Quantity quantity = Quantity::kNone;
  };
  api::Ticket ticket = 0;
  std::vector<Entry> entries;  ///< empty before the first such command
};
[[nodiscard]] GuardedCommand to_guarded_command(api::Ticket ticket,
                                                const std::vector<crcl::Guard>& guards,
                                                const SensorBoard& sensors,
                                                const crcl::Units& units);

// Targets outside the limits that a robot reports, before the robot plans.

/// Box of allowed tool points in the robot's reference frame [m].
struct CartesianLimits {
  Eigen::Vector3d min_R = Eigen::Vector3d::Zero(), max_R = Eigen::Vector3d::Zero();
};

/// The robot's reach, narrowed by the configured limits.
[[nodiscard]] CartesianLimits cartesian_limits(const api::RobotDescription& robot,
                                               const std::optional<Eigen::Vector3d>& min_R,
                                               const std::optional<Eigen::Vector3d>& max_R);

/// With `clamp`, moves a target outside the limits to the nearest point within and returns a note.
/// Else a target outside is an error that names axis, value, limit and unit. Empty for a target
/// within. The robot itself still refuses targets that it cannot reach.
[[nodiscard]] Result<std::optional<std::string>> fit(Pose& X_RT, const CartesianLimits& limits,
                                                     bool clamp, crcl::LengthUnit unit);
/// The same for the ranges of joints; those of the arm alone are left to the robot when not
/// `clamp`.
[[nodiscard]] Result<std::optional<std::string>> fit(std::vector<WireTarget>& targets,
                                                     const JointMap& joints, bool clamp,
                                                     crcl::AngleUnit unit);

}  // namespace aprsim::crcl_server
