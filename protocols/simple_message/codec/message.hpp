#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <variant>
#include <vector>

/// ROS-Industrial's Simple Message as values: REP-I0004 (types), REP-I0006 (layouts), and the
/// vendor messages of MotoROS. Positions [rad], velocities [rad/s], accelerations [rad/s^2], times
/// [s]. Every structure lists its fields in the order of the wire. Pure.
namespace aprsim::simple_message {

inline constexpr std::size_t kWireJoints = 10;   ///< always sent; unused ones are 0
inline constexpr std::size_t kGroups = 4;        ///< control groups of an extended message
inline constexpr std::size_t kDhValues = 8 * 4;  ///< eight links of theta, d, a, alpha

enum class MessageType : std::int32_t {
  kPing = 1,
  kJointPosition = 10,
  kTrajectoryPoint = 11,
  kRobotStatus = 13,
  kTrajectoryPointFull = 14,
  kJointFeedback = 15,
  kMotionControl = 2001,
  kMotionReply = 2002,
  kReadIoBit = 2003,
  kReadIoBitReply = 2004,
  kWriteIoBit = 2005,
  kWriteIoBitReply = 2006,
  kReadIoGroup = 2007,
  kReadIoGroupReply = 2008,
  kWriteIoGroup = 2009,
  kWriteIoGroupReply = 2010,
  kReadRegister = 2012,   ///< the reply has the same type
  kWriteRegister = 2013,  ///< the reply has the same type
  kTrajectoryPointsExtended = 2016,
  kJointFeedbackExtended = 2017,
  kSelectTool = 2018,
  kDhParameters = 2020,
};

enum class Communication : std::int32_t { kTopic = 1, kServiceRequest = 2, kServiceReply = 3 };
/// Whether the service was carried out; the motion may still fail.
enum class ReplyCode : std::int32_t { kNone = 0, kSuccess = 1, kFailure = 2 };

/// Commands of kMotionControl.
enum class MotionCommand : std::int32_t {
  kCheckMotionReady = 200101,
  kCheckQueueCount = 200102,
  kStopMotion = 200111,
  kStartServos = 200112,
  kStopServos = 200113,
  kResetAlarm = 200114,
  kStartTrajectoryMode = 200121,
  kStopTrajectoryMode = 200122,
  kDisconnect = 200130,
};

/// Result of a kMotionReply.
enum class MotionResult : std::int32_t {
  kSuccess = 0,
  kBusy = 1,
  kFailure = 2,
  kInvalid = 3,
  kAlarm = 4,
  kNotReady = 5,
  kApiFailure = 6,
};

/// Subcode of a kMotionReply with the result kInvalid (3000s) or kNotReady (5000s).
enum class Subcode : std::int32_t {
  kNone = 0,
  kMessageSize = 3001,
  kMessageHeader = 3002,
  kMessageType = 3003,
  kGroupNumber = 3004,
  kSequence = 3005,
  kCommand = 3006,
  kData = 3010,
  kStartPosition = 3011,
  kSpeed = 3013,
  kMissingFields = 3015,
  kTime = 3016,
  kToolNumber = 3017,
  kUnspecified = 5000,
  kAlarm = 5001,
  kError = 5002,
  kEmergencyStop = 5003,
  kNotPlay = 5004,
  kNotRemote = 5005,
  kServoOff = 5006,
  kHold = 5007,
  kNotStarted = 5008,
  kNotWaiting = 5009,
  kIncrementRefused = 5012,
};

// Special sequence numbers.
inline constexpr std::int32_t kStartDownload = -1, kStartStreaming = -2, kEndTrajectory = -3,
                              kStopTrajectory = -4;

/// Bits of `valid`.
inline constexpr std::int32_t kTimeValid = 1, kPositionValid = 2, kVelocityValid = 4,
                              kAccelerationValid = 8;

inline constexpr std::int32_t kManualMode = 1, kAutomaticMode = 2;

using Joints = std::array<float, kWireJoints>;

struct Ping {
  template <typename Fields>
  void visit(Fields&) {}
};

struct JointPosition {
  std::int32_t sequence = 0;
  Joints position{};

  template <typename Fields>
  void visit(Fields& fields) {
    fields("sequence", sequence);
    fields("position", position);
  }
};

struct TrajectoryPoint {
  std::int32_t sequence = 0;
  Joints position{};
  float velocity = 0;  ///< a fraction
  float duration = 0;  ///< [s]

  template <typename Fields>
  void visit(Fields& fields) {
    fields("sequence", sequence);
    fields("position", position);
    fields("velocity", velocity);
    fields("duration", duration);
  }
};

/// Truths are -1 (unknown), 0 or 1.
struct RobotStatus {
  std::int32_t drives_powered = -1, e_stopped = -1, error_code = 0, in_error = -1, in_motion = -1;
  std::int32_t mode = -1, motion_possible = -1;

  template <typename Fields>
  void visit(Fields& fields) {
    fields("drives_powered", drives_powered);
    fields("e_stopped", e_stopped);
    fields("error_code", error_code);
    fields("in_error", in_error);
    fields("in_motion", in_motion);
    fields("mode", mode);
    fields("motion_possible", motion_possible);
  }
};

struct TrajectoryPointFull {
  std::int32_t group = 0, sequence = 0, valid = 0;
  float time = 0;  ///< since the trajectory's start [s]
  Joints position{}, velocity{}, acceleration{};

  template <typename Fields>
  void visit(Fields& fields) {
    fields("robot_id", group);
    fields("sequence", sequence);
    fields("valid", valid);
    fields("time", time);
    fields("position", position);
    fields("velocity", velocity);
    fields("acceleration", acceleration);
  }
};

struct JointFeedback {
  std::int32_t group = 0, valid = 0;
  float time = 0;  ///< [s]
  Joints position{}, velocity{}, acceleration{};

  template <typename Fields>
  void visit(Fields& fields) {
    fields("robot_id", group);
    fields("valid", valid);
    fields("time", time);
    fields("position", position);
    fields("velocity", velocity);
    fields("acceleration", acceleration);
  }
};

struct MotionControl {
  std::int32_t group = 0, sequence = 0, command = 0;
  Joints data{};

  template <typename Fields>
  void visit(Fields& fields) {
    fields("robot_id", group);
    fields("sequence", sequence);
    fields("command", command);
    fields("data", data);
  }
};

struct MotionReply {
  std::int32_t group = 0, sequence = 0;
  std::int32_t command = 0;  ///< of a MotionControl; of other requests their type
  std::int32_t result = 0, subcode = 0;
  Joints data{};

  template <typename Fields>
  void visit(Fields& fields) {
    fields("robot_id", group);
    fields("sequence", sequence);
    fields("command", command);
    fields("result", result);
    fields("subcode", subcode);
    fields("data", data);
  }
};

/// Reads a bit, a group of eight bits or a register, by the message's type.
struct ReadIo {
  std::int32_t address = 0;

  template <typename Fields>
  void visit(Fields& fields) {
    fields("address", address);
  }
};

/// Writes a bit, a group of eight bits or a register, by the message's type.
struct WriteIo {
  std::int32_t address = 0, value = 0;

  template <typename Fields>
  void visit(Fields& fields) {
    fields("address", address);
    fields("value", value);
  }
};

struct ReadIoReply {
  std::int32_t value = 0, result = 0;

  template <typename Fields>
  void visit(Fields& fields) {
    fields("value", value);
    fields("result", result);
  }
};

struct WriteIoReply {
  std::int32_t result = 0;

  template <typename Fields>
  void visit(Fields& fields) {
    fields("result", result);
  }
};

/// A point for up to four groups at once; the sender may leave out the unused ones.
struct TrajectoryPointsExtended {
  std::int32_t groups = 0, sequence = 0;
  std::array<JointFeedback, kGroups> points{};

  template <typename Fields>
  void visit(Fields& fields) {
    fields("groups", groups);
    fields("sequence", sequence);
    fields("points", points);
  }
};

struct JointFeedbackExtended {
  std::int32_t groups = 0;
  std::array<JointFeedback, kGroups> feedback{};

  template <typename Fields>
  void visit(Fields& fields) {
    fields("groups", groups);
    fields("feedback", feedback);
  }
};

struct SelectTool {
  std::int32_t group = 0, tool = 0, sequence = 0;

  template <typename Fields>
  void visit(Fields& fields) {
    fields("robot_id", group);
    fields("tool", tool);
    fields("sequence", sequence);
  }
};

struct GetDhParameters {
  template <typename Fields>
  void visit(Fields&) {}
};

struct DhParameters {
  std::array<std::array<float, kDhValues>, kGroups> groups{};

  template <typename Fields>
  void visit(Fields& fields) {
    fields("groups", groups);
  }
};

using Body = std::variant<Ping, JointPosition, TrajectoryPoint, RobotStatus, TrajectoryPointFull,
                          JointFeedback, MotionControl, MotionReply, ReadIo, WriteIo, ReadIoReply,
                          WriteIoReply, TrajectoryPointsExtended, JointFeedbackExtended, SelectTool,
                          GetDhParameters, DhParameters>;

struct Message {
  MessageType type = MessageType::kPing;
  Communication communication = Communication::kTopic;
  ReplyCode reply = ReplyCode::kNone;
  Body body;
};

}  // namespace aprsim::simple_message
