#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/crcl/crcl_session.hpp"
#include "protocols/ports/robot_port.hpp"

namespace aprsim::crcl_server {

/// A session whose client is in this process: another listener, on behalf of its own client.
/// SetEndEffector is over once the gripper has settled, and statuses hold every part.
/// Does not pace virtual time. Keeps itself alive while an operation is pending.
class PortSession final : public protocols::RobotSession,
                          public SessionWire,
                          public std::enable_shared_from_this<PortSession> {
 public:
  using OnEnd = std::function<void(PortSession&)>;

  /// `on_end` is called once, on the server's thread.
  PortSession(const protocols::RobotSessionOptions& asked,
              std::shared_ptr<protocols::RobotClient> client, const CrclServerOptions& options,
              CommandExecutor& executor, CrclCounters& counters, boost::asio::any_io_executor io,
              OnEnd on_end);

  // From the client. Thread: any.
  void send(crcl::Result<crcl::CommandInstance> command) override;
  void send(crcl::Result<crcl::Program> program) override;
  void execute(crcl::Result<crcl::CommandInstance> command) override;
  void report_every(std::chrono::nanoseconds period) override;
  void close() override;

  // From the server. Thread: its.

  /// Ends the session and tells the client why.
  void end(ErrorCode code, const std::string& reason);
  void break_off() { end(ErrorCode::kUnavailable, "the connection was cut by an injected fault"); }

 private:
  // The wire, as the session sees it.
  [[nodiscard]] std::shared_ptr<SessionWire> hold() override { return shared_from_this(); }
  [[nodiscard]] bool carries_documents() const override { return false; }
  [[nodiscard]] bool closed() const override { return closed_; }
  [[nodiscard]] bool ended() const override { return closed_; }
  [[nodiscard]] bool admits_command() override { return !closed_; }
  void send(Answer answer) override;
  void send_half(Answer /*answer*/) override { break_off(); }
  void on_room() override {}
  void on_taken() override;
  void watch_end() override {}
  void refuse(const std::string& reason) override;
  void drop(const std::string& reason) override;

  void post(std::function<void()> work);
  void take(Received received);
  void report();
  void watch_over();
  void close_now();

  std::shared_ptr<protocols::RobotClient> client_;
  CommandExecutor& executor_;
  boost::asio::any_io_executor io_;
  OnEnd on_end_;
  CrclSession session_;
  boost::asio::steady_timer report_timer_, over_timer_;
  std::chrono::nanoseconds period_{};  // of statuses
  bool taking_ = false;                // what the client has sent
  bool executes_ = false;              // the client is notified of the end of its command
  std::uint64_t command_ = 0;          // the executor's count of it
  bool closed_ = false;
};

}  // namespace aprsim::crcl_server
