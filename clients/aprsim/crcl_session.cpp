#include "clients/aprsim/crcl_session.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "crcl/command_codec.hpp"
#include "crcl/status_codec.hpp"

namespace aprsim::client {

using std::chrono::steady_clock;

namespace {

constexpr auto kConnectTimeout = std::chrono::seconds(5);
constexpr auto kAnswerTimeout = std::chrono::seconds(10);
constexpr auto kPollInterval = std::chrono::milliseconds(20);

}  // namespace

CrclSession::CrclSession(TcpSocket socket, std::string robot)
    : socket_(std::move(socket)), robot_(std::move(robot)) {}

Outcome<CrclSession> CrclSession::connect(const Endpoints& endpoints, const std::string& robot) {
  const auto port = crcl_port(endpoints, robot);
  if (!port) return tl::unexpected(port.error());
  auto socket = TcpSocket::connect(endpoints.host, *port, steady_clock::now() + kConnectTimeout);
  if (!socket) {
    return failed(socket.error().kind,
                  fmt::format("cannot reach {} by CRCL at {}", robot, socket.error().message));
  }
  CrclSession session(std::move(*socket), robot);
  const auto status = session.status();
  if (!status) return tl::unexpected(status.error());
  session.last_id_ = std::max<std::int64_t>(0, status->command.command_id);
  return session;
}

Outcome<void> CrclSession::send_raw(const std::string& bytes) {
  auto sent = socket_.send(bytes, steady_clock::now() + kAnswerTimeout);
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
    const auto bytes = socket_.receive(deadline);
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
  command.id = std::max(command.id, last_id_ + 1);
  last_id_ = command.id;
  if (const auto sent = send_raw(crcl::encode_command(instance)); !sent) {
    return tl::unexpected(sent.error());
  }
  return wait_done(command.id, timeout, std::string(crcl::type_name(command.body)));
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
      if (command.state == crcl::CommandState::kDone) return status;
      if (command.state == crcl::CommandState::kError) {
        return failed(FailureKind::kRefused,
                      fmt::format("{}: {} {} ended in CRCL_Error: {}", robot_, what, id,
                                  command.description.value_or("no description given")));
      }
    } else if (begun) {
      return failed(FailureKind::kRefused,
                    fmt::format("{}: {} {} was replaced by command {} of another client", robot_,
                                what, id, command.command_id));
    }
    if (steady_clock::now() > deadline) {
      return failed(FailureKind::kTimeout,
                    fmt::format("{}: {} {} is not done after {:.1f} s ({})", robot_, what, id,
                                timeout.count(), crcl::name_of(command.state)));
    }
    std::this_thread::sleep_for(kPollInterval);
  }
}

}  // namespace aprsim::client
