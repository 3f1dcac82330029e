#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/aprsim/trace/action.hpp"
#include "protocols/simple_message/codec/message_codec.hpp"

namespace aprsim::trace {
namespace {

using namespace simple_message;

constexpr auto kOrder = ByteOrder::kBig;
constexpr std::size_t kFanucJoints = 6, kMotomanJoints = 7;
// Words of the Fanuc's gripper server.
constexpr std::int32_t kOpenWord = 0, kCloseWord = 1, kAskStateWord = 3, kEndWord = 99;

std::span<const std::uint8_t> message_bytes(const std::string& data) {
  return {reinterpret_cast<const std::uint8_t*>(data.data()), data.size()};
}

std::string command_name(std::int32_t command) {
  using enum MotionCommand;
  switch (static_cast<MotionCommand>(command)) {
    case kCheckMotionReady:
      return "CHECK_MOTION_READY";
    case kCheckQueueCount:
      return "CHECK_QUEUE_CNT";
    case kStopMotion:
      return "STOP_MOTION";
    case kStartServos:
      return "START_SERVOS";
    case kStopServos:
      return "STOP_SERVOS";
    case kResetAlarm:
      return "RESET_ALARM";
    case kStartTrajectoryMode:
      return "START_TRAJ_MODE";
    case kStopTrajectoryMode:
      return "STOP_TRAJ_MODE";
    case kDisconnect:
      return "DISCONNECT";
  }
  return fmt::format("motion command {}", command);
}

bool is_check(std::int32_t command) {
  return command == static_cast<std::int32_t>(MotionCommand::kCheckMotionReady) ||
         command == static_cast<std::int32_t>(MotionCommand::kCheckQueueCount);
}

std::string motion_outcome(const MotionReply& reply) {
  static constexpr const char* kResults[] = {"done",  "busy",      "failure",    "invalid",
                                             "alarm", "not ready", "API failure"};
  const auto result = static_cast<std::size_t>(reply.result);
  std::string text =
      result < std::size(kResults) ? kResults[result] : fmt::format("result {}", reply.result);
  if (reply.result != 0 && reply.subcode != 0) text += fmt::format(" {}", reply.subcode);
  return text;
}

/// A point of a trajectory, from whichever message.
struct StreamedPoint {
  std::int32_t sequence = 0;
  std::optional<double> time_s;
  std::vector<double> joints_rad;
};

std::vector<double> first_joints(const Joints& joints, std::size_t count) {
  return {joints.begin(), joints.begin() + static_cast<std::ptrdiff_t>(count)};
}

std::optional<StreamedPoint> streamed_point(const Message& message) {
  if (const auto* full = std::get_if<TrajectoryPointFull>(&message.body)) {
    return StreamedPoint{full->sequence, full->time, first_joints(full->position, kMotomanJoints)};
  }
  if (const auto* points = std::get_if<TrajectoryPointsExtended>(&message.body)) {
    const auto& first = points->points.front();
    return StreamedPoint{points->sequence, first.time,
                         first_joints(first.position, kMotomanJoints)};
  }
  if (const auto* point = std::get_if<TrajectoryPoint>(&message.body)) {
    return StreamedPoint{point->sequence, std::nullopt,
                         first_joints(point->position, kFanucJoints)};
  }
  if (const auto* position = std::get_if<JointPosition>(&message.body)) {
    return StreamedPoint{position->sequence, std::nullopt,
                         first_joints(position->position, kFanucJoints)};
  }
  return std::nullopt;
}

/// Whether the reply asks for the point once more.
bool asks_again(const Message& reply) {
  const auto* motion = std::get_if<MotionReply>(&reply.body);
  return motion != nullptr && motion->result == static_cast<std::int32_t>(MotionResult::kBusy);
}

/// Reads the requests and replies of one port of a robot.
class SimpleMessageReader {
 public:
  void take(const WireRecord& record) {
    if (record.wire.content() == v1::WIRE_CONTENT_RECEIVED) request(record);
    if (record.wire.content() == v1::WIRE_CONTENT_SENT) reply(record);
  }
  WireActions take_result() {
    for (Action& action : out_.actions) {
      if (action.outcome.empty()) action.outcome = "no answer";
    }
    return std::move(out_);
  }

 private:
  /// A request without a reply yet.
  struct OpenMessage {
    std::optional<std::size_t> action;  ///< absent = a read
    std::optional<StreamedPoint> point;
  };
  struct Connection {
    std::deque<OpenMessage> open;           ///< in the order of sending
    std::optional<std::size_t> trajectory;  ///< the action of the present one
    std::optional<std::int32_t> sequence;   ///< of its latest point
    std::size_t points = 0;                 ///< of these that were accepted
  };

  void request(const WireRecord& record) {
    Connection& connection = connections_[record.wire.connection()];
    const auto bytes = message_bytes(record.wire.data());
    if (bytes.size() == kWordSize) return word(record, connection, bytes.first<kWordSize>());
    const auto message = decode_request(bytes, kOrder);
    if (!message) {
      Action action{.kind = "wrong request", .time_s = record.time_s};
      action.fields.push_back({"fault", message.error().message});
      return add(connection, std::move(action));
    }
    if (const auto point = streamed_point(*message)) return add_point(record, connection, *point);
    if (const auto* control = std::get_if<MotionControl>(&message->body)) {
      const std::string name = command_name(control->command);
      if (is_check(control->command)) return poll(connection, name);
      return add(connection, {.kind = name, .time_s = record.time_s});
    }
    other(record, connection, *message);
  }

  void word(const WireRecord& record, Connection& connection,
            std::span<const std::uint8_t, kWordSize> bytes) {
    const std::int32_t value = decode_word(bytes, kOrder);
    if (value == kAskStateWord) return poll(connection, "the gripper's state");
    Action action{.kind = value == kOpenWord    ? "open gripper"
                          : value == kCloseWord ? "close gripper"
                          : value == kEndWord   ? "end"
                                                : fmt::format("gripper command {}", value),
                  .time_s = record.time_s};
    if (value == kEndWord) action.outcome = "done";  // it has no reply
    const bool replied = value != kEndWord;
    out_.actions.push_back(std::move(action));
    if (replied) connection.open.push_back({out_.actions.size() - 1, std::nullopt});
  }

  void other(const WireRecord& record, Connection& connection, const Message& message) {
    const auto type = static_cast<std::int32_t>(message.type);
    if (const auto* read = std::get_if<ReadIo>(&message.body)) {
      return poll(connection, fmt::format("signal {}", read->address));
    }
    if (const auto* write = std::get_if<WriteIo>(&message.body)) {
      Action action{.kind = fmt::format("write signal {}", write->address),
                    .time_s = record.time_s};
      action.fields.push_back(
          {"value", Number{Quantity::kCount, static_cast<double>(write->value)}});
      return add(connection, std::move(action));
    }
    if (const auto* tool = std::get_if<SelectTool>(&message.body)) {
      Action action{.kind = "SELECT_TOOL", .time_s = record.time_s};
      action.fields.push_back({"tool", Number{Quantity::kCount, static_cast<double>(tool->tool)}});
      return add(connection, std::move(action));
    }
    poll(connection,
         message.type == MessageType::kPing ? std::string("ping") : fmt::format("type {}", type));
  }

  void poll(Connection& connection, const std::string& what) {
    ++out_.polls;
    ++out_.reads[what];
    connection.open.push_back({std::nullopt, std::nullopt});
  }

  void add(Connection& connection, Action action) {
    connection.trajectory.reset();
    connection.sequence.reset();
    out_.actions.push_back(std::move(action));
    connection.open.push_back({out_.actions.size() - 1, std::nullopt});
  }

  /// Points with rising numbers are one trajectory.
  void add_point(const WireRecord& record, Connection& connection, const StreamedPoint& point) {
    if (point.sequence < 0) {
      return add(connection, {.kind = point.sequence == kStopTrajectory
                                          ? "stop trajectory"
                                          : fmt::format("sequence number {}", point.sequence),
                              .time_s = record.time_s});
    }
    const bool goes_on =
        connection.sequence && point.sequence >= *connection.sequence && point.sequence != 0;
    if (!goes_on) {
      out_.actions.push_back({.kind = "trajectory", .time_s = record.time_s});
      connection.trajectory = out_.actions.size() - 1;
      connection.points = 0;
    }
    connection.sequence = point.sequence;
    connection.open.push_back({connection.trajectory, point});
  }

  void reply(const WireRecord& record) {
    Connection& connection = connections_[record.wire.connection()];
    const auto message = decode_reply(message_bytes(record.wire.data()), kOrder);
    if (connection.open.empty()) {
      // A state, or the Fanuc's report of a point that it has acknowledged.
      const bool failed = message && message->reply == ReplyCode::kFailure;
      if (failed && connection.trajectory) {
        out_.actions[*connection.trajectory].outcome = "failure";
      } else {
        ++out_.polls;
      }
      return;
    }
    const OpenMessage request = std::move(connection.open.front());
    connection.open.pop_front();
    if (!request.action) return;
    Action& action = out_.actions[*request.action];
    action.duration_s = record.time_s - action.time_s;
    if (request.point) return point_reply(connection, action, *request.point, message);
    action.outcome = outcome(message);
  }

  void point_reply(Connection& connection, Action& action, const StreamedPoint& point,
                   const Result<Message>& reply) {
    if (reply && asks_again(*reply)) return;
    action.outcome = outcome(reply);
    if (action.outcome != "done") return;
    ++connection.points;
    action.fields = {{"points", Number{Quantity::kCount, static_cast<double>(connection.points)}}};
    if (point.time_s) action.fields.push_back({"time", Number{Quantity::kWait, *point.time_s}});
    for (std::size_t i = 0; i < point.joints_rad.size(); ++i) {
      action.fields.push_back(
          {fmt::format("joint {}", i + 1), Number{Quantity::kAngle, point.joints_rad[i]}});
    }
  }

  static std::string outcome(const Result<Message>& reply) {
    if (!reply) return "done";  // a word of the gripper server
    if (const auto* motion = std::get_if<MotionReply>(&reply->body)) return motion_outcome(*motion);
    const auto* write = std::get_if<WriteIoReply>(&reply->body);
    if (write != nullptr && write->result != 0) return fmt::format("result {}", write->result);
    return reply->reply == ReplyCode::kFailure ? "failure" : "done";
  }

  std::map<std::uint64_t, Connection> connections_;
  WireActions out_;
};

}  // namespace

WireActions simple_message_actions(const Records& records) {
  SimpleMessageReader reader;
  for (const WireRecord* record : records) reader.take(*record);
  return reader.take_result();
}

}  // namespace aprsim::trace
