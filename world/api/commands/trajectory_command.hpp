#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "world/api/values/ticket.hpp"
#include "world/base/time.hpp"

/// Streams of joint motions: a motion source of a robot beside the commands of CRCL.
///
/// A robot has one commander at a time. ClaimMotion makes its sender the commander; the ticket of
/// the claim is the number of the stream, which every later command of the stream names.
/// FollowTrajectory is claim, points and release in one command. A stream ends by its release, by
/// an alarm, and by every stop of the robot: StopMotion, a protective stop, a shutdown. Its end is
/// in MotionSnapshot::ends.
///
/// A command that cannot be carried out changes nothing and is in Snapshot::failures under its
/// ticket. A point beyond a limit of the robot is an alarm: the robot stops, the stream ends, and
/// MotionSnapshot::alarm is set until InitRobot or a claim with `reset`.
namespace aprsim::api {

inline constexpr std::size_t kMaxTrajectoryPoints = 4000;  ///< that wait in a stream
inline constexpr std::size_t kMaxWaitingMoves = 16;
inline constexpr std::size_t kMaxCommanderName = 128;  ///< [bytes]
/// Longest trajectory, as the FS100 has it.
inline constexpr SimTime kMaxTrajectoryTime = std::chrono::hours(4);

/// A posture at a time, on a smooth curve through all points: between two points that have
/// velocities a cubic polynomial, with accelerations too a quintic one, else a straight line.
/// The vectors have one value for each joint.
struct TrajectoryPoint {
  SimTime time{};  ///< since the trajectory's start
  std::vector<double> position_rad{};
  std::vector<double> velocity_rad_s{};       ///< empty = none
  std::vector<double> acceleration_rad_s2{};  ///< empty = none; only with velocities
};

/// How a stream moves the robot.
enum class StreamMode {
  kTimed,  ///< AppendPoints: at the points' times
  kMoves,  ///< AppendMove: from posture to posture at a share of the joints' speeds
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr StreamMode last_of(StreamMode) { return StreamMode::kMoves; }

/// Begins a stream. Errors: kFailedPrecondition while another commander has the robot (named), a
/// command moves it or its tool changer works, and while an alarm is held. Switches the drives on.
struct ClaimMotion {
  std::string commander;  ///< shown to others: who it is, and from where
  StreamMode mode = StreamMode::kTimed;
  bool reset = false;  ///< clears a held alarm and error before, as InitRobot does
  /// Ends this stream before, if the robot has it: its commander has gone. 0 = none.
  Ticket takes_over = 0;
};

/// Adds points to a timed stream. Errors: kInvalidArgument for a point with other than one value
/// for each joint, a time that does not increase, a first point at time 0 that is not where the
/// robot is (within 0.01 rad); kUnavailable for too many points; kFailedPrecondition for `begins`
/// while an earlier trajectory is under way.
struct AppendPoints {
  Ticket stream = 0;
  /// A new trajectory: its time begins at the next step, and its first motion where the robot is,
  /// at rest. The first points of a stream always begin one. A first point at time 0 moves nothing.
  bool begins = false;
  std::vector<TrajectoryPoint> points{};
  /// The points follow those up to this time of the present trajectory, or up to a millisecond from
  /// now if that is later; the others that are left are dropped. None = follow all that are left.
  std::optional<SimTime> ends_at{};
};

/// Adds a move to a stream of moves: all joints arrive together. Errors: kUnavailable while
/// `max_waiting` moves wait for the present one.
struct AppendMove {
  Ticket stream = 0;
  std::vector<double> position_rad{};  ///< one for each joint
  double speed = 1;                    ///< share of the joints' speeds, above 0 to 1
  /// Share of the deceleration, 0..1, that the next move overlaps if it waits by then (Fanuc's
  /// CNT / 100). 0 = stops.
  double rounding = 0;
  std::size_t max_waiting = 1;  ///< 1 to kMaxWaitingMoves
};

/// Stops all joints as fast as they can and drops the points; the stream goes on. A new trajectory
/// or move may follow once MotionSnapshot::phase is kReady.
struct StopStream {
  Ticket stream = 0;
};

/// Slows down on the path until the robot stands, or goes on from there. Points are kept, but for
/// those of a timed stream after `ends_at`, a time of the present trajectory: its curve ends there.
struct PauseStream {
  Ticket stream = 0;
  bool paused = true;
  std::optional<SimTime> ends_at{};
};

/// Ends the stream: stops as StopStream does, or first executes all points.
struct ReleaseMotion {
  Ticket stream = 0;
  bool when_done = false;
};

/// The largest differences from a trajectory; 0 = any. For one joint.
struct JointTolerance {
  double position_rad = 0;
  double velocity_rad_s = 0;
};

/// Follows a whole trajectory, as control_msgs/FollowJointTrajectory. Errors as of ClaimMotion; the
/// outcome, and the refusal of the trajectory itself, is in MotionSnapshot::ends under the
/// command's ticket, which is the number of the stream.
struct FollowTrajectory {
  std::string commander;
  std::vector<std::string> joint_names{};  ///< order of all values; empty = the robot's
  std::vector<TrajectoryPoint> points{};
  /// Simulated time of its start; absent = at once. A time that has passed is refused.
  std::optional<SimTime> start{};
  std::vector<JointTolerance> path_tolerance{};  ///< one for each joint; empty = any
  std::vector<JointTolerance> goal_tolerance{};  ///< one for each joint; empty = any
  bool reset = false;                            ///< as in ClaimMotion
  SimTime goal_time_tolerance{};  ///< after the last point's time; 0 = waits for the goal
};

/// Switches the valves of the gripper, as outputs of the controller do: beside any motion, of an
/// uninitialized or faulty robot too, and without a trace in the robot's command status.
struct SwitchGripper {
  double setting = 0;  ///< as in SetGripper
};

using TrajectoryAction = std::variant<ClaimMotion, AppendPoints, AppendMove, StopStream,
                                      PauseStream, ReleaseMotion, FollowTrajectory, SwitchGripper>;

struct TrajectoryCommand {
  int robot = 0;  ///< index into CellDescription::robots
  TrajectoryAction action;
};

}  // namespace aprsim::api
