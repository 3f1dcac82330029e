#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "world/api/guard.hpp"
#include "world/api/light_curtain.hpp"
#include "world/api/pose.hpp"
#include "world/api/ticket.hpp"
#include "world/api/time.hpp"

/// Everything that a listener may ask of the world. Plain values in SI units; a command says what
/// is wanted, never how a wire encoded it.
namespace aprsim::api {

/// Identifies the listener or client session that sent a command (kept in the journal).
using EndpointId = std::uint32_t;

// ---- one robot -------------------------------------------------------------------------------

/// Aborts any motion without leaving the present position, clears a held error, makes ready.
struct InitRobot {};
/// Ends a session: stops motion; the robot holds its position.
struct EndRobot {};

enum class StopKind {
  kImmediate,  ///< drives off and brakes: as fast as the joints can, the path may be left
  kFast,       ///< controlled stop on the path at maximal deceleration
  kNormal,     ///< braking ramp on the path at the set deceleration
};
struct StopMotion {
  StopKind kind = StopKind::kNormal;
};

/// One limit of the tool's motion: absolute [m/s, m/s^2, rad/s, rad/s^2], or relative as a fraction
/// 0..1 of the robot's maximum.
struct LimitSetting {
  bool relative = false;
  double value = 0;
};

/// Limits for the way to one pose only; what is absent is as SetMotionLimit has set it.
struct PoseLimits {
  std::optional<LimitSetting> trans_speed{}, trans_accel{}, rot_speed{}, rot_accel{};
};

/// How near a pose must be passed: distances along the axes of R, angles of the tool's x and z
/// axes. What is absent is bounded by the robot's own defaults.
struct PoseTolerance {
  std::optional<double> x_m{}, y_m{}, z_m{}, x_axis_rad{}, z_axis_rad{};
};

/// Moves the tool frame T to a pose in the robot's reference frame R (the frame of CRCL poses).
struct MoveTo {
  Pose X_RT;
  bool straight = false;  ///< straight line of the tool point with shortest rotation; else free
  PoseLimits limits{};
  PoseTolerance tolerance{};  ///< an arm that is pushed aside by more has not arrived
};

inline constexpr std::size_t kMaxWaypoints = 1000;
struct Waypoint {
  Pose X_RT;
  PoseLimits limits{};        ///< for the way to it
  PoseTolerance tolerance{};  ///< for passing it; the last one's is as in MoveTo
};
/// Moves the tool past every waypoint within its tolerance and ends at the last one, without
/// stopping in between unless a tolerance leaves no room.
struct MoveThroughTo {
  std::vector<Waypoint> waypoints;
  bool straight = false;  ///< straight between the waypoints; else free
};

/// Moves freely to `start`, then along the tool's z axis by `free_m`, then on a helix: the tool
/// turns by `turn_rad` about its own z axis, or about the parallel to it through `axis_point_R`,
/// while it advances along it by `screw_m`. Positive: away from the robot, right-handed about z.
struct MoveScrew {
  std::optional<Waypoint> start{};
  std::optional<Eigen::Vector3d> axis_point_R{};
  double free_m = 0, screw_m = 0, turn_rad = 0;
};

/// Drives a joint by torque instead of speed.
struct JointTorque {
  double setting_nm = 0;              ///< magnitude against what it meets, > 0
  std::optional<double> rate_nm_s{};  ///< builds up so fast; absent = at once
};

struct JointTarget {
  int joint = 0;  ///< 0-based
  double position_rad = 0;
  std::optional<double> speed_rad_s;
  std::optional<double> accel_rad_s2;
  /// Towards the position until it is reached or what stands in the way bears the torque.
  std::optional<JointTorque> torque{};
  /// A joint that is pushed aside by more has not arrived.
  std::optional<double> tolerance_rad{};
};
/// Moves the named joints, each with its own optional speed and acceleration; joints that are not
/// named hold their present target.
struct MoveJoints {
  std::vector<JointTarget> targets;
};

/// 0 = closed, 1 = open. A gripper that is not proportional opens above 0.5.
struct SetGripper {
  double setting = 0;
};

/// Opens the tool changer: the gripper stays where it is and the tool frame becomes the flange's.
/// Or closes it: a gripper that sits at the flange is taken and the tool frame is its again.
struct SetToolChanger {
  bool open = false;
};

/// Scales the speed of running and later motion, smoothly; 0 holds a motion where it is.
struct SetOverride {
  double fraction = 1;  ///< 0..1
};

/// Sets the supply pressure of a pneumatic gripper by the force that each finger then presses with.
struct SetGripperForce {
  double force_n = 0;  ///< above 0, at most GripperDescription::force_n
};

/// Holds position for a span of simulated time.
struct Dwell {
  SimTime duration{};
};

enum class MotionLimit { kTransSpeed, kTransAccel, kRotSpeed, kRotAccel };
/// Sets one of the limits that later moves obey. Absolute [m/s, m/s^2, rad/s, rad/s^2], or
/// relative as a fraction 0..1 of the robot's maximum.
struct SetMotionLimit {
  MotionLimit which = MotionLimit::kTransSpeed;
  bool relative = false;
  double value = 0;
};

using RobotAction =
    std::variant<InitRobot, EndRobot, StopMotion, MoveTo, MoveThroughTo, MoveScrew, MoveJoints,
                 SetGripper, SetGripperForce, SetToolChanger, SetOverride, Dwell, SetMotionLimit>;

/// Which of RobotAction's commands, in its order.
enum class ActionKind {
  kNone,
  kInit,
  kEnd,
  kStop,
  kMoveTo,
  kMoveThroughTo,
  kMoveScrew,
  kMoveJoints,
  kGripper,
  kGripperForce,
  kToolChanger,
  kOverride,
  kDwell,
  kMotionLimit,
};
static_assert(std::variant_size_v<RobotAction> ==
              static_cast<std::size_t>(ActionKind::kMotionLimit));
[[nodiscard]] inline ActionKind kind_of(const RobotAction& action) {
  return static_cast<ActionKind>(action.index() + 1);
}

struct RobotCommand {
  int robot = 0;  ///< index into CellDescription::robots
  RobotAction action;
  /// End the action; at most kMaxGuards. A setting has none.
  std::vector<Guard> guards{};
};

// ---- conveyor --------------------------------------------------------------------------------

/// Sets any of the drive's inputs; what is absent stays as it is. Every command feeds the watchdog.
struct ConveyorCommand {
  std::optional<bool> run;             ///< true is ignored while a fault is held
  std::optional<bool> forward;         ///< true = along the belt's +x axis
  std::optional<double> speed_m_s;     ///< magnitude, >= 0
  std::optional<bool> emergency_stop;  ///< true engages (and holds a fault), false releases
  bool fault_reset = false;            ///< clears a held fault unless its cause persists
  /// The drive trips if it is told to run and gets no command for so long, in simulated time;
  /// 0 = never.
  std::optional<double> watchdog_s;
};

// ---- what is not the cell's own ----------------------------------------------------------------

/// Puts the intruder into the cell or moves it; nullopt takes it away. A reset does so too.
struct SetIntruder {
  std::optional<Intruder> intruder;
};

// ---- the simulation itself -------------------------------------------------------------------

struct Pause {};
struct Resume {};
/// Advances exactly this many steps while paused (or stepped), then stays paused.
struct StepBy {
  std::uint64_t steps = 1;
};
/// Target ratio of simulated to wall time; nullopt = as fast as possible. Never changes the step.
struct SetSpeed {
  std::optional<double> factor;
};
/// Builds the world anew from its scene. Sockets stay open; Snapshot::epoch rises by one.
struct Reset {
  std::optional<std::uint64_t> seed;
};

inline constexpr std::size_t kMaxSavedStates = 64;
inline constexpr std::size_t kMaxStateName = 64;
/// Keeps the present state of the world under a name, in place of what had it; ignored when
/// kMaxSavedStates others are kept. Saved states outlive resets, not the process.
struct SaveState {
  std::string name;
};
/// Goes on from a saved state, bit for bit; ignored when none has the name. Snapshot::epoch rises
/// by one.
struct LoadState {
  std::string name;
};
using SimulationCommand =
    std::variant<Pause, Resume, StepBy, SetSpeed, Reset, SaveState, LoadState>;

struct Command {
  EndpointId endpoint = 0;
  std::variant<RobotCommand, ConveyorCommand, SetIntruder, SimulationCommand> body;
};

}  // namespace aprsim::api
