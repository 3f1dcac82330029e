#include "clients/wires/crcl_session.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "crcl/command_codec.hpp"
#include "crcl/status_codec.hpp"

namespace aprsim::client {

using std::chrono::steady_clock;

namespace {

constexpr auto kAnswerTimeout = std::chrono::seconds(10);
constexpr auto kPollInterval = std::chrono::milliseconds(20);
constexpr CrclSession::Seconds kStopTimeout{5};

/// A command that was cancelled before it was sent.
tl::unexpected<Failure> not_sent() { return failed(FailureKind::kInterrupted, "interrupted"); }

}  // namespace

CrclSession::CrclSession(TcpSocket socket, std::string robot, Cancelled cancelled)
    : socket_(std::move(socket)), robot_(std::move(robot)), cancelled_(std::move(cancelled)) {}

Outcome<CrclSession> CrclSession::connect(const Endpoints& endpoints, const std::string& robot,
                                          Cancelled cancelled) {
  const auto port = crcl_port(endpoints, robot);
  if (!port) return tl::unexpected(port.error());
  auto socket = TcpSocket::connect(endpoints.host, *port,
                                   steady_clock::now() + TcpSocket::kConnectTimeout, cancelled);
  if (!socket) {
    return failed(socket.error().kind,
                  fmt::format("cannot reach {} by CRCL at {}", robot, socket.error().message));
  }
  CrclSession session(std::move(*socket), robot, std::move(cancelled));
  const auto status = session.status();
  if (!status) return tl::unexpected(status.error());
  session.last_id_ = std::max<std::int64_t>(0, status->command.command_id);
  return session;
}

Outcome<void> CrclSession::send_raw(const std::string& bytes) {
  auto sent = socket_.send(bytes, steady_clock::now() + kAnswerTimeout, cancelled_);
  if (!sent) return failed(sent.error().kind, robot_ + ": " + sent.error().message);
  return sent;
}

Outcome<crcl::Status> CrclSession::status() {
  crcl::CommandInstance instance;
  instance.command.id = std::max<std::int64_t>(1, last_id_);
  instance.command.body = crcl::GetStatus{};
  if (const auto sent = send_raw(crcl::encode_command(instance)); !sent) {
    return tl::unexpected(sent.error());
  }
  return read_status();
}

Outcome<crcl::Status> CrclSession::read_status() {
  const auto deadline = steady_clock::now() + kAnswerTimeout;
  while (true) {
    auto document = framer_.next();
    if (!document) return failed(FailureKind::kConnection, document.error().message());
    if (*document) {
      auto status = crcl::decode_status(**document);
      if (!status) {
        return failed(FailureKind::kConnection,
                      fmt::format("{} sent a status that cannot be read: {}", robot_,
                                  status.error().message()));
      }
      return std::move(*status);
    }
    const auto bytes = socket_.receive(deadline, cancelled_);
    if (!bytes) return failed(bytes.error().kind, robot_ + ": " + bytes.error().message);
    framer_.append(*bytes);
  }
}

Outcome<crcl::Status> CrclSession::run(crcl::CommandBody body, Seconds timeout) {
  crcl::CommandInstance instance;
  instance.command.body = std::move(body);
  return run(std::move(instance), timeout);
}

Outcome<crcl::Status> CrclSession::run(crcl::CommandInstance instance, Seconds timeout) {
  auto& command = instance.command;
  if (std::holds_alternative<crcl::GetStatus>(command.body)) return status();
  if (is_cancelled(cancelled_)) return not_sent();
  command.id = std::max(command.id, last_id_ + 1);
  last_id_ = command.id;
  under_way_ = true;
  if (const auto sent = send_raw(crcl::encode_command(instance)); !sent) {
    return tl::unexpected(sent.error());
  }
  return wait_done(command.id, timeout, std::string(crcl::type_name(command.body)));
}

Outcome<crcl::Status> CrclSession::run_document(const std::string& document,
                                                const crcl::Command& command, Seconds timeout) {
  const bool asks = std::holds_alternative<crcl::GetStatus>(command.body);
  if (is_cancelled(cancelled_)) return not_sent();
  last_id_ = std::max(last_id_, command.id);
  under_way_ = under_way_ || !asks;
  if (const auto sent = send_raw(document); !sent) return tl::unexpected(sent.error());
  if (asks) return read_status();
  return wait_done(command.id, timeout, std::string(crcl::type_name(command.body)));
}

Outcome<void> CrclSession::stop() {
  if (!under_way_) return {};
  Cancelled cancelled = std::exchange(cancelled_, {});
  const auto stopped = run(crcl::StopMotion{}, kStopTimeout);
  cancelled_ = std::move(cancelled);
  if (!stopped) return tl::unexpected(stopped.error());
  return {};
}

Failure CrclSession::stopped_after(const Failure& failure) {
  if (!is_cancelled(cancelled_)) return failure;
  const bool moved = under_way_;
  const auto stopped = stop();
  return {FailureKind::kInterrupted,
          stopped
              ? fmt::format("interrupted{}", moved ? "; " + robot_ + " has stopped" : "")
              : fmt::format("interrupted; {} MAY STILL MOVE: {}", robot_, stopped.error().message)};
}

Outcome<crcl::Status> CrclSession::wait_done(std::int64_t id, Seconds timeout,
                                             const std::string& what) {
  const auto deadline =
      steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(timeout);
  bool begun = false;
  while (true) {
    auto status = this->status();
    if (!status) return status;
    const auto& command = status->command;
    if (command.command_id == id) {
      begun = true;
      under_way_ =
          command.state != crcl::CommandState::kDone && command.state != crcl::CommandState::kError;
      if (command.state == crcl::CommandState::kDone) return status;
      if (command.state == crcl::CommandState::kError) {
        return failed(FailureKind::kRefused,
                      fmt::format("{}: {} {} ended in CRCL_Error: {}", robot_, what, id,
                                  command.description.value_or("no description given")));
      }
    } else if (begun) {
      under_way_ = false;
      return failed(FailureKind::kRefused,
                    fmt::format("{}: {} {} was replaced by command {} of another client", robot_,
                                what, id, command.command_id));
    }
    if (is_cancelled(cancelled_)) {
      return failed(FailureKind::kInterrupted,
                    fmt::format("{}: {} {} was interrupted", robot_, what, id));
    }
    if (steady_clock::now() > deadline) {
      return failed(FailureKind::kTimeout,
                    fmt::format("{}: {} {} is not done after {:.1f} s ({})", robot_, what, id,
                                timeout.count(), crcl::name_of(command.state)));
    }
    sleep_until(steady_clock::now() + kPollInterval, cancelled_);
  }
}

}  // namespace aprsim::client
