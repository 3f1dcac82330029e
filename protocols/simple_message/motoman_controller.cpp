#include "protocols/simple_message/motoman_controller.hpp"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "protocols/simple_message/codec/message_codec.hpp"

namespace aprsim::simple_message {
namespace {

constexpr std::chrono::milliseconds kMotomanStatePeriod{25};
/// The tasks of a connection live on for so long when it has ended.
constexpr std::chrono::milliseconds kPauseDelay{50};
/// Deviation of a trajectory's start from the commanded position.
constexpr std::int64_t kStartPulses = 30;
constexpr float kMaxTime_s = 14400;
constexpr std::int32_t kTools = 64;
/// Speeds of the axes S L E U R B T that a point may have [rad/s].
constexpr std::array<float, 7> kMaxSpeeds{2.27F, 2.27F, 2.97F, 2.97F, 3.49F, 3.49F, 6.98F};

MotionReply with(MotionReply reply, MotionResult result, Subcode subcode = Subcode::kNone) {
  reply.result = static_cast<std::int32_t>(result);
  reply.subcode = static_cast<std::int32_t>(subcode);
  return reply;
}

MotionReply reply_to(std::int32_t group, std::int32_t sequence, MessageType type) {
  return {group, sequence, static_cast<std::int32_t>(type), 0, 0, {}};
}

/// MotoROS compares whole numbers: a speed is too high from the next whole rad/s on.
bool too_fast(const Joints& velocity) {
  for (std::size_t i = 0; i < kMaxSpeeds.size(); ++i) {
    if (std::floor(std::abs(velocity[i])) > kMaxSpeeds[i]) return true;
  }
  return false;
}

/// MotoROS multiplies floats, so that 0.9 s is 900 ms.
std::int64_t milliseconds_of(float time_s) { return static_cast<std::int64_t>(time_s * 1000.0F); }

/// As a controller understands it: only requests of its programs.
bool is_motion_request(MessageType type) {
  using enum MessageType;
  switch (type) {
    case kJointPosition:
    case kTrajectoryPoint:
    case kReadRegister:
    case kWriteRegister:
      return false;
    default:
      return true;
  }
}

/// Messages that only a controller sends: the program ends the connection.
bool is_controllers_own(MessageType type) {
  using enum MessageType;
  return type == kRobotStatus || type == kJointFeedback || type == kMotionReply ||
         type == kJointFeedbackExtended;
}

}  // namespace

MotomanController::MotomanController(ListenerContext& context, RobotLink& link)
    : context_(context),
      link_(link),
      io_(link),
      queue_(link, context.options.interpolation_clock),
      ends_(context.log),
      pause_timer_(context.io) {}

std::chrono::milliseconds MotomanController::state_period() const { return kMotomanStatePeriod; }

// ---- connections

void MotomanController::motion_connected(Connection& connection) {
  ends_.commanded_by(connection.peer());
  connected_ = true;
  pause_timer_.cancel();
  if (!std::exchange(paused_, false) || stream_ == 0) return;
  // The queue goes on where it was, if the job still runs.
  static_cast<void>(link_.submit(api::PauseStream{stream_, false}));
}

void MotomanController::motion_gone(Connection& connection) {
  connected_ = false;
  if (owes(connection)) pending_.reset();
  // In virtual time nothing may depend on the wall's.
  const bool is_virtual = context_.options.listener.virtual_time != nullptr;
  pause_timer_.expires_after(is_virtual ? std::chrono::milliseconds(0) : kPauseDelay);
  pause_timer_.async_wait([this](const boost::system::error_code& cancelled) {
    if (!cancelled && !connected_) pause();
  });
}

/// The tasks of a lost client end: what they have not cut into increments is lost.
void MotomanController::pause() {
  const api::SnapshotPtr now = link_.latest();
  follow_stream(*now);
  if (stream_ == 0 || queue_.empty(*now)) return;
  const auto ends_at = queue_.drop_uncut(*now);
  paused_ = link_.submit(api::PauseStream{stream_, true, ends_at}).has_value();
}

bool MotomanController::yields_motion() {
  const api::SnapshotPtr now = link_.latest();
  follow_stream(*now);
  return stream_ == 0 || queue_.empty(*now);
}

// ---- state

void MotomanController::follow_stream(const api::Snapshot& now) {
  const bool lost =
      stream_ != 0 && now.applied >= stream_ && link_.robot(now).motion.stream != stream_;
  if (now.epoch != epoch_ || lost) {
    epoch_ = now.epoch;
    stream_ = 0;
    paused_ = false;
    queue_.clear();
  }
}

bool MotomanController::is_ready(const api::Snapshot& now) {
  follow_stream(now);
  const ControllerState state = link_.state(now, stream_);
  return state.has_stream && !state.in_error && !state.e_stopped && state.drives_on;
}

Subcode MotomanController::not_ready_reason(const api::Snapshot& now) {
  const ControllerState state = link_.state(now, stream_);
  if (state.in_error && !state.e_stopped) return Subcode::kAlarm;
  if (state.e_stopped) return Subcode::kEmergencyStop;
  if (!state.drives_on) return Subcode::kServoOff;
  // Another job that has the robot is not at the WAIT of INIT_ROS.
  return state.others_command ? Subcode::kNotWaiting : Subcode::kNotStarted;
}

std::vector<std::string> MotomanController::states() {
  const api::SnapshotPtr now = link_.latest();
  const bool ready = is_ready(*now);
  const ControllerState state = link_.state(*now, stream_);
  const bool lags = !within_pulses(state.measured_rad, state.reference_rad, kStartPulses);
  const bool queued = stream_ != 0 && !queue_.empty(*now);
  const RobotStatus status{state.drives_on,
                           state.e_stopped,
                           state.in_error ? state.error_code : 0,
                           state.in_error,
                           state.moving || queued || lags,
                           kAutomaticMode,
                           ready};
  return {encode({MessageType::kJointFeedback, Communication::kTopic, ReplyCode::kNone,
                  JointFeedback{
                      0, kPositionValid | kVelocityValid, 0, state.position, state.velocity, {}}},
                 context_.order),
          encode({MessageType::kRobotStatus, Communication::kTopic, ReplyCode::kNone, status},
                 context_.order)};
}

// ---- requests

void MotomanController::send(Connection& connection, Communication asked, MotionReply reply) {
  if (reply.result != 0) ++context_.counters.rejected;
  // A reply is not replied to.
  if (asked == Communication::kServiceReply) return;
  connection.reply(
      encode({MessageType::kMotionReply, Communication::kServiceReply, ReplyCode::kSuccess, reply},
             context_.order));
}

bool MotomanController::take_motion(Connection& connection, std::span<const std::uint8_t> request,
                                    bool known_length) {
  if (pending_) return false;
  const auto header = decode_header(request, context_.order);
  const auto type = static_cast<MessageType>(header->type);
  const auto asked = static_cast<Communication>(header->communication);
  const auto message = decode_request(request, context_.order);
  connection.record_request(request, message ? std::string() : message.error().message);
  const MotionReply unknown = reply_to(-1, -1, type);
  if (!known_length || !request_body_size(type) || !is_motion_request(type)) {
    send(connection, asked, with(unknown, MotionResult::kInvalid, Subcode::kMessageType));
    return true;
  }
  if (is_controllers_own(type)) {
    connection.close("it sends what only a controller sends", true);
    return true;
  }
  if (!message) {
    context_.log.warn(connection.peer() + ": " + message.error().message);
    send(connection, asked, with(unknown, MotionResult::kInvalid, Subcode::kData));
    return true;
  }
  const auto reply = answer(connection, *message);
  if (reply && asked != Communication::kServiceReply) {
    connection.reply(encode(*reply, context_.order));
  }
  return true;
}

std::optional<Message> MotomanController::answer(Connection& connection, const Message& request) {
  const auto motion_reply = [&](const MotionReply& reply) {
    if (reply.result != 0) ++context_.counters.rejected;
    return Message{MessageType::kMotionReply, Communication::kServiceReply, ReplyCode::kSuccess,
                   reply};
  };
  if (request.type == MessageType::kPing) {
    return Message{MessageType::kPing, Communication::kServiceReply, ReplyCode::kSuccess, Ping{}};
  }
  if (const auto* full = std::get_if<TrajectoryPointFull>(&request.body)) {
    return motion_reply(take_point(
        {full->group, full->sequence, full->valid, full->time, full->position, full->velocity},
        request.type));
  }
  if (const auto* points = std::get_if<TrajectoryPointsExtended>(&request.body)) {
    return motion_reply(take_points(*points));
  }
  if (const auto* tool = std::get_if<SelectTool>(&request.body)) {
    return motion_reply(select_tool(*tool));
  }
  if (std::holds_alternative<MotionControl>(request.body)) {
    const auto reply = control(connection, request);
    if (!reply) return std::nullopt;
    return motion_reply(*reply);
  }
  if (request.type == MessageType::kDhParameters) {
    // The parameters of the arm are not known to the cell in this form.
    return Message{request.type, Communication::kServiceReply, ReplyCode::kFailure, DhParameters{}};
  }
  return io_.answer(request, is_ready(*link_.latest()));
}

MotionReply MotomanController::select_tool(const SelectTool& request) const {
  const MotionReply reply = reply_to(request.group, request.sequence, MessageType::kSelectTool);
  if (request.group != 0) return with(reply, MotionResult::kInvalid, Subcode::kGroupNumber);
  if (request.tool < 0 || request.tool >= kTools) {
    return with(reply, MotionResult::kInvalid, Subcode::kToolNumber);
  }
  return with(reply, MotionResult::kSuccess);
}

bool MotomanController::take_gripper(Connection& connection, std::span<const std::uint8_t> request,
                                     bool known_length) {
  const auto message = decode_request(request, context_.order);
  connection.record_request(request, message ? std::string() : message.error().message);
  const auto reply =
      message && known_length ? io_.answer(*message, is_ready(*link_.latest())) : std::nullopt;
  if (reply) {
    if (reply->reply != ReplyCode::kSuccess) ++context_.counters.rejected;
    connection.reply(encode(*reply, context_.order));
    return true;
  }
  // The I/O server writes result and subcode over the first two fields of the body.
  ++context_.counters.rejected;
  const MotionReply refusal{static_cast<std::int32_t>(MotionResult::kInvalid),
                            static_cast<std::int32_t>(Subcode::kMessageType),
                            0,
                            0,
                            0,
                            {}};
  connection.reply(encode(
      {MessageType::kMotionReply, Communication::kServiceReply, ReplyCode::kSuccess, refusal},
      context_.order));
  return true;
}

// ---- points

MotionReply MotomanController::take_point(const Point& point, MessageType type) {
  const auto [result, subcode] = judge(point);
  return with(reply_to(point.group, point.sequence, type), result, subcode);
}

MotionReply MotomanController::take_points(const TrajectoryPointsExtended& points) {
  const auto& first = points.points.front();
  if (points.groups != 1) {
    return with(reply_to(first.group, points.sequence, MessageType::kTrajectoryPointsExtended),
                MotionResult::kInvalid, Subcode::kGroupNumber);
  }
  return take_point(
      {first.group, points.sequence, first.valid, first.time, first.position, first.velocity},
      MessageType::kTrajectoryPointsExtended);
}

std::pair<MotionResult, Subcode> MotomanController::judge(const Point& point) {
  constexpr std::int32_t kNeeded = kTimeValid | kPositionValid | kVelocityValid;
  const api::SnapshotPtr now = link_.latest();
  if (!is_ready(*now)) return {MotionResult::kNotReady, not_ready_reason(*now)};
  if (point.group != 0) return {MotionResult::kInvalid, Subcode::kGroupNumber};
  if ((point.valid & kNeeded) != kNeeded) {
    return {MotionResult::kInvalid, Subcode::kMissingFields};
  }
  if (point.time >= kMaxTime_s) return {MotionResult::kInvalid, Subcode::kTime};
  if (point.sequence < 0) return {MotionResult::kInvalid, Subcode::kSequence};
  return add(point, *now);
}

std::pair<MotionResult, Subcode> MotomanController::add(const Point& point,
                                                        const api::Snapshot& now) {
  const std::size_t count = link_.description(now).joints.size();
  JointVector position = from_wire(ControllerKind::kMotomanFs100, point.position, count);
  const bool first = point.sequence == 0;
  if (first) {
    const ControllerState state = link_.state(now, stream_);
    if (!within_pulses(position, state.reference_rad, kStartPulses)) {
      return {MotionResult::kInvalid, Subcode::kStartPosition};
    }
  } else if (queue_.is_cutting(now)) {
    return {MotionResult::kBusy, Subcode::kNone};
  }
  if (too_fast(point.velocity)) return {MotionResult::kInvalid, Subcode::kSpeed};
  const std::int64_t time_ms = milliseconds_of(point.time);
  if (first) {
    queue_.begin(time_ms);
    return {MotionResult::kSuccess, Subcode::kNone};
  }
  const auto added = queue_.add(time_ms, on_whole_pulses(std::move(position)),
                                from_wire(ControllerKind::kMotomanFs100, point.velocity, count));
  if (added) return {MotionResult::kSuccess, Subcode::kNone};
  context_.log.warn("a point is not taken: " + added.error().message);
  return added.error().code == ErrorCode::kUnavailable
             ? std::pair{MotionResult::kBusy, Subcode::kNone}
             : std::pair{MotionResult::kInvalid, Subcode::kData};
}

// ---- control

std::optional<MotionReply> MotomanController::control(Connection& connection,
                                                      const Message& request) {
  const auto& asked = std::get<MotionControl>(request.body);
  const MotionReply reply{asked.group, asked.sequence, asked.command, 0, 0, {}};
  const api::SnapshotPtr now = link_.latest();
  using enum MotionCommand;
  switch (static_cast<MotionCommand>(asked.command)) {
    case kCheckMotionReady:
      if (is_ready(*now)) return with(reply, MotionResult::kSuccess);
      return with(reply, MotionResult::kFailure, not_ready_reason(*now));
    case kCheckQueueCount: {
      if (asked.group != 0) return with(reply, MotionResult::kFailure, static_cast<Subcode>(-1));
      follow_stream(*now);
      const auto count = stream_ == 0 ? 0 : queue_.count(*now);
      return with(reply, MotionResult::kSuccess, static_cast<Subcode>(count));
    }
    case kStopMotion:
      follow_stream(*now);
      queue_.clear();
      if (stream_ != 0 && !link_.submit(api::StopStream{stream_})) {
        return with(reply, MotionResult::kFailure);
      }
      return with(reply, MotionResult::kSuccess);
    case kStartServos:
      set_servos(connection, request, reply, true);
      return std::nullopt;
    case kStopServos:
      set_servos(connection, request, reply, false);
      return std::nullopt;
    case kResetAlarm:
      reset_alarm(connection, request, reply);
      return std::nullopt;
    case kStartTrajectoryMode:
      start_trajectory_mode(connection, request, reply);
      return std::nullopt;
    case kStopTrajectoryMode:
      return stop_trajectory_mode(connection, reply, false);
    case kDisconnect:
      return stop_trajectory_mode(connection, reply, true);
  }
  return with(reply, MotionResult::kInvalid, Subcode::kCommand);
}

void MotomanController::await(
    Connection& connection, const Message& request, MotionReply reply,
    std::function<std::optional<MotionResult>(const api::Snapshot&)> result) {
  pending_ = Pending{&connection, reply, request.communication,
                     clock(*link_.latest()) + context_.options.claim_timeout, std::move(result)};
  advance();
}

std::chrono::nanoseconds MotomanController::clock(const api::Snapshot& now) const {
  if (context_.options.listener.virtual_time != nullptr) return now.time;
  return std::chrono::steady_clock::now().time_since_epoch();
}

/// A claim of the robot. A stream of this controller from an earlier time, as a saved state has it,
/// is taken over.
std::optional<api::Ticket> MotomanController::claim(const std::string& who, bool reset) {
  const api::SnapshotPtr now = link_.latest();
  const api::MotionSnapshot& motion = link_.robot(*now).motion;
  const bool own = motion.source == api::MotionSource::kStream &&
                   motion.commander.starts_with(context_.log.name() + " ");
  const auto ticket = link_.submit(api::ClaimMotion{
      context_.log.name() + " of " + who, api::StreamMode::kTimed, reset, own ? motion.stream : 0});
  if (!ticket) {
    context_.log.warn("the robot cannot be claimed: " + ticket.error().message);
    return std::nullopt;
  }
  return *ticket;
}

void MotomanController::start_trajectory_mode(Connection& connection, const Message& request,
                                              MotionReply reply) {
  const api::SnapshotPtr now = link_.latest();
  const bool ready = is_ready(*now);
  const ControllerState state = link_.state(*now, stream_);
  const bool own = link_.robot(*now).motion.commander.starts_with(context_.log.name() + " ");
  if (ready || (state.others_command && !own) || state.e_stopped) {
    const MotionReply answer = ready ? with(reply, MotionResult::kSuccess)
                                     : with(reply, MotionResult::kNotReady, not_ready_reason(*now));
    return send(connection, request.communication, answer);
  }
  const auto ticket = claim(connection.peer(), true);
  if (!ticket) {
    return send(connection, request.communication,
                with(reply, MotionResult::kNotReady, Subcode::kNotStarted));
  }
  stream_ = *ticket;
  paused_ = false;
  queue_.begin_stream(*ticket);
  ends_.expect(*ticket, connection.peer());
  await(connection, request, reply,
        [this, stream = *ticket](const api::Snapshot& seen) -> std::optional<MotionResult> {
          if (seen.applied < stream) return std::nullopt;
          if (is_ready(seen)) return MotionResult::kSuccess;
          // Drives may take a while.
          if (link_.robot(seen).motion.stream == stream) return std::nullopt;
          return MotionResult::kNotReady;
        });
}

std::optional<MotionReply> MotomanController::stop_trajectory_mode(Connection& connection,
                                                                   MotionReply reply,
                                                                   bool disconnect) {
  const api::SnapshotPtr now = link_.latest();
  follow_stream(*now);
  if (stream_ != 0 && !queue_.empty(*now)) return with(reply, MotionResult::kFailure);
  if (stream_ != 0) {
    if (!link_.submit(api::ReleaseMotion{stream_, false})) {
      return with(reply, MotionResult::kFailure);
    }
    stream_ = 0;
    queue_.clear();
  }
  if (!disconnect) return with(reply, MotionResult::kSuccess);
  connection.finish("the client ends it");
  return std::nullopt;
}

void MotomanController::set_servos(Connection& connection, const Message& request,
                                   MotionReply reply, bool on) {
  api::Ticket ticket = 0;
  const api::SnapshotPtr now = link_.latest();
  const bool are_on = link_.state(*now, stream_).drives_on;
  if (on && !are_on) {
    // A claim switches them on; they stay on when it is given back.
    const auto claimed = claim(connection.peer(), false);
    if (claimed) {
      ticket = *claimed;
      static_cast<void>(link_.submit(api::ReleaseMotion{ticket, false}));
    }
  } else if (!on) {
    queue_.clear();
    const auto stopped = link_.submit(api::StopMotion{api::StopKind::kImmediate});
    if (stopped) ticket = *stopped;
  }
  await(connection, request, reply,
        [this, ticket, on](const api::Snapshot& seen) -> std::optional<MotionResult> {
          if (seen.applied < ticket) return std::nullopt;
          if (link_.robot(seen).drives_on == on) return MotionResult::kSuccess;
          return std::nullopt;
        });
}

void MotomanController::reset_alarm(Connection& connection, const Message& request,
                                    MotionReply reply) {
  const api::SnapshotPtr now = link_.latest();
  follow_stream(*now);
  api::Ticket ticket = 0;
  if (link_.state(*now, stream_).in_error) {
    const auto claimed = claim(connection.peer(), true);
    if (claimed) {
      ticket = *claimed;
      static_cast<void>(link_.submit(api::ReleaseMotion{ticket, false}));
    }
  }
  await(connection, request, reply,
        [this, ticket](const api::Snapshot& seen) -> std::optional<MotionResult> {
          if (seen.applied < ticket) return std::nullopt;
          return link_.state(seen, stream_).in_error ? MotionResult::kFailure
                                                     : MotionResult::kSuccess;
        });
}

void MotomanController::advance() {
  const api::SnapshotPtr now = link_.latest();
  follow_stream(*now);
  if (stream_ != 0) queue_.advance(*now);
  if (!pending_) return;
  auto result = pending_->result(*now);
  if (!result && clock(*now) < pending_->deadline) return;
  const Pending done = *std::exchange(pending_, std::nullopt);
  const bool starts =
      done.reply.command == static_cast<std::int32_t>(MotionCommand::kStartTrajectoryMode);
  if (!result) result = starts ? MotionResult::kNotReady : MotionResult::kFailure;
  const Subcode subcode =
      *result == MotionResult::kNotReady ? not_ready_reason(*now) : Subcode::kNone;
  send(*done.connection, done.communication, with(done.reply, *result, subcode));
}

}  // namespace aprsim::simple_message
