#include "protocols/simple_message/fanuc_controller.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "protocols/simple_message/codec/message_codec.hpp"

namespace aprsim::simple_message {
namespace {

/// Karel's loop of 42 Hz, in whole milliseconds.
constexpr std::chrono::milliseconds kFanucStatePeriod{24};
/// A status follows every eleventh position.
constexpr int kPositionsPerStatus = 11;
/// The motion program moves to one point and knows one more.
constexpr std::uint64_t kPointsOfProgram = 2;

// Words of the gripper server.
constexpr std::int32_t kOpen = 0, kClose = 1, kAskState = 3, kEnd = 99;

std::string position_message(Communication communication, ReplyCode code, std::int32_t sequence,
                             const Joints& joints) {
  return encode({MessageType::kJointPosition, communication, code, JointPosition{sequence, joints}},
                ByteOrder::kBig);
}

}  // namespace

FanucController::FanucController(ListenerContext& context, RobotLink& link)
    : context_(context), link_(link), gripper_(link), ends_(context.log) {}

void FanucController::motion_connected(Connection& connection) { client_ = &connection; }

void FanucController::motion_gone(Connection&) {
  client_ = nullptr;
  point_.reset();
  release();
}

// The program still executes what it was handed.
void FanucController::release() {
  if (stream_ == 0) return;
  const auto released = link_.submit(api::ReleaseMotion{stream_, true});
  if (!released) context_.log.warn("the robot cannot be released: " + released.error().message);
  stream_ = 0;
}

void FanucController::acknowledge(Connection& connection, std::int32_t sequence, ReplyCode code) {
  if (code != ReplyCode::kSuccess) ++context_.counters.rejected;
  connection.reply(position_message(Communication::kServiceReply, code, sequence, {}));
}

bool FanucController::take_motion(Connection& connection, std::span<const std::uint8_t> request,
                                  bool) {
  const api::SnapshotPtr now = link_.latest();
  follow_stream(*now);
  if (point_ || !program_is_free(*now)) return false;
  const auto sequence = decode_word(request.subspan<kHeaderSize, kLengthSize>(), context_.order);
  // Neither type nor length of a request is checked, only its numbers.
  JointPosition position;
  std::string fault;
  std::string bytes(request.begin(), request.end());
  bytes.replace(
      kLengthSize, kLengthSize,
      encode_word(static_cast<std::int32_t>(MessageType::kJointPosition), context_.order));
  const auto message = decode_request(
      {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, context_.order);
  if (message) {
    position = std::get<JointPosition>(message->body);
  } else {
    fault = message.error().message;
  }
  connection.record_request(request, fault);
  if (sequence < 0) {
    take_special(connection, sequence);
    return true;
  }
  const std::size_t count = link_.description(*now).joints.size();
  JointVector joints = from_wire(ControllerKind::kFanucKarel, position.position, count);
  if (!message || !in_range(joints, *now)) {
    // The relay acknowledges what it reads, then reports the point and leaves its client.
    acknowledge(connection, sequence, ReplyCode::kSuccess);
    acknowledge(connection, sequence, ReplyCode::kFailure);
    context_.log.warn(fmt::format("{}: point {} is out of range", connection.peer(), sequence));
    connection.finish("a point out of range");
    return true;
  }
  point_ = std::move(joints);
  hand_over(*now);
  acknowledge(connection, sequence, ReplyCode::kSuccess);
  return true;
}

void FanucController::take_special(Connection& connection, std::int32_t sequence) {
  if (sequence != kStopTrajectory) {
    context_.log.warn(
        fmt::format("{}: sequence number {} is ignored", connection.peer(), sequence));
    return;
  }
  if (stream_ != 0) {
    const auto stopped = link_.submit(api::StopStream{stream_});
    if (stopped) latest_ = *stopped;
  }
  acknowledge(connection, sequence, ReplyCode::kSuccess);
}

bool FanucController::in_range(const JointVector& joints, const api::Snapshot& now) const {
  const auto& limits = link_.description(now).joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    // The wire's numbers are floats: a limit itself is within.
    constexpr double kRounding_rad = 1e-6;
    if (!(joints[i] >= limits[i].lower_rad - kRounding_rad &&
          joints[i] <= limits[i].upper_rad + kRounding_rad)) {
      return false;
    }
  }
  return true;
}

// A stop of the robot, and its alarm, end the program with all of its points.
void FanucController::follow_stream(const api::Snapshot& now) {
  if (now.epoch != epoch_) {
    epoch_ = now.epoch;
    stream_ = 0;
    point_.reset();
  }
  const bool lost =
      stream_ != 0 && now.applied >= stream_ && link_.robot(now).motion.stream != stream_;
  if (lost) stream_ = 0;
}

bool FanucController::program_is_free(const api::Snapshot& now) const {
  if (stream_ == 0) return true;
  if (now.applied < latest_) return false;
  const auto& motion = link_.robot(now).motion;
  return motion.points_left < kPointsOfProgram && motion.phase != api::StreamPhase::kStopping;
}

void FanucController::hand_over(const api::Snapshot& now) {
  if (!point_ || !program_is_free(now)) return;
  if (stream_ == 0) {
    // The program runs only where the robot is free and without a fault; until then it waits.
    const api::MotionSnapshot& motion = link_.robot(now).motion;
    const ControllerState state = link_.state(now, 0);
    // A stream of this program from an earlier time, as a saved state has it, stands for ever.
    const bool is_left = motion.commander.starts_with(context_.log.name() + " ") &&
                         motion.phase == api::StreamPhase::kReady;
    if (now.applied < latest_ || (state.others_command && !is_left) || state.in_error ||
        state.e_stopped) {
      return;
    }
    const std::string peer = client_ != nullptr ? client_->peer() : "nobody";
    const auto claim =
        link_.submit(api::ClaimMotion{context_.log.name() + " of " + peer, api::StreamMode::kMoves,
                                      true, is_left ? motion.stream : 0});
    if (!claim) return;
    stream_ = latest_ = *claim;
    ends_.expect(stream_, peer);
  }
  JointVector joints = *point_;
  const auto& limits = link_.description(now).joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i] = std::clamp(joints[i], limits[i].lower_rad, limits[i].upper_rad);
  }
  const auto move = link_.submit(api::AppendMove{
      stream_, std::move(joints), context_.options.joint_speed, context_.options.rounding, 1});
  if (!move) return;
  latest_ = *move;
  point_.reset();
}

void FanucController::advance() {
  const api::SnapshotPtr now = link_.latest();
  follow_stream(*now);
  hand_over(*now);
}

std::chrono::milliseconds FanucController::state_period() const { return kFanucStatePeriod; }

std::vector<std::string> FanucController::states() {
  const api::SnapshotPtr now = link_.latest();
  const ControllerState state = link_.state(*now, stream_);
  std::vector<std::string> messages{
      position_message(Communication::kTopic, ReplyCode::kNone, 0, state.position)};
  if (++positions_ < kPositionsPerStatus) return messages;
  positions_ = 0;
  const bool possible = !state.in_error && !state.e_stopped && state.drives_on &&
                        link_.robot(*now).motion.phase != api::StreamPhase::kPaused;
  messages.push_back(encode({MessageType::kRobotStatus, Communication::kTopic, ReplyCode::kNone,
                             RobotStatus{state.drives_on, state.e_stopped, state.error_code,
                                         state.in_error, state.moving, kAutomaticMode, possible}},
                            ByteOrder::kBig));
  return messages;
}

bool FanucController::take_gripper(Connection& connection, std::span<const std::uint8_t> request,
                                   bool) {
  const auto word = decode_word(request.first<kLengthSize>(), context_.order);
  connection.record_request(request);
  Result<void> done;
  if (word == kOpen || word == kClose) {
    done = gripper_.actuate(word == kOpen);
  } else if (word == kEnd) {
    connection.finish("the client ends it");
    return true;
  } else if (word != kAskState) {
    ++context_.counters.rejected;
    connection.close(fmt::format("gripper command {} is none of 0, 1, 3, 99", word), true);
    return true;
  }
  if (!done) {
    ++context_.counters.rejected;
    context_.log.warn(connection.peer() + ": the gripper does not move: " + done.error().message);
  }
  connection.reply(encode_word(gripper_.is_open() ? kOpen : kClose, context_.order));
  return true;
}

}  // namespace aprsim::simple_message
