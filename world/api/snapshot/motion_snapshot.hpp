#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "world/api/commands/trajectory_command.hpp"
#include "world/api/values/joint_count.hpp"
#include "world/api/values/ticket.hpp"
#include "world/base/time.hpp"
#include "world/base/with_appended.hpp"

/// The source of a robot's motion.
namespace aprsim::api {

enum class MotionSource {
  kNone,      ///< the robot is free
  kCommands,  ///< a command of CRCL, gRPC or the page moves it or changes its tool
  kStream,    ///< a stream has it (trajectory_command.hpp), moving or not
};

enum class StreamPhase {
  kNone,      ///< no stream
  kReady,     ///< at rest without points
  kMoving,    ///< on its way, or waiting for its start
  kPaused,    ///< slowing down, or standing on its path
  kStopping,  ///< StopStream: until it stands
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr StreamPhase last_of(StreamPhase) { return StreamPhase::kStopping; }

/// How a stream has ended; the negative ones with the numbers of
/// control_msgs/FollowJointTrajectory_Result.
enum class StreamResult {
  kSuccessful,             ///< released, or the goal is reached
  kInvalidGoal,            ///< -1: a point is malformed or beyond a limit
  kInvalidJoints,          ///< -2: the names are not those of the robot's joints
  kOldHeaderTimestamp,     ///< -3: the start has passed
  kPathToleranceViolated,  ///< -4
  kGoalToleranceViolated,  ///< -5
  kCancelled,              ///< released in mid-motion
  kStopped,                ///< by a stop of the robot
  kAlarm,                  ///< a point of a stream is beyond a limit of the robot
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr StreamResult last_of(StreamResult) { return StreamResult::kAlarm; }

struct StreamEnd {
  Ticket stream = 0;
  StreamResult result = StreamResult::kSuccessful;
  std::string text;  ///< joint, value, limit and unit; or who stopped it
};
inline constexpr std::size_t kMaxStreamEnds = 8;

struct MotionSnapshot {
  MotionSource source = MotionSource::kNone;
  StreamPhase phase = StreamPhase::kNone;
  std::string commander;  ///< of the stream
  Ticket stream = 0;      ///< its number; 0 = none
  /// Accepted points or moves that the robot has not reached; the present one included.
  std::uint64_t points_left = 0;
  std::uint64_t points_done = 0;  ///< reached since the claim
  SimTime time{};                 ///< of the present trajectory, since its start
  SimTime end_time{};             ///< of its last accepted point
  /// The commanded motion, before the servo: where the next trajectory begins.
  std::array<double, kMaxJoints> reference_rad{}, reference_rad_s{};
  /// Not empty: the robot takes no motion until InitRobot or a claim with `reset`, and why. A
  /// stream's alarm, a protective stop or a shutdown.
  std::string alarm;
  SharedList<StreamEnd> ends;  ///< of the latest kMaxStreamEnds streams; null = none
};

}  // namespace aprsim::api
