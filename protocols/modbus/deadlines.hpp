#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/modbus/modbus_server.hpp"

namespace aprsim::modbus_server {

/// Deadlines of a client: to finish its TLS handshake, to complete a request, to take its replies,
/// to send a request. One timer, which an ordinary request does not restart. Thread: the
/// executor's.
class Deadlines {
 public:
  using Clock = std::chrono::steady_clock;

  /// `on_due` is called when one of them may have passed, and asks for it by missed().
  Deadlines(const boost::asio::any_io_executor& io, const ModbusServerOptions& options,
            std::function<void()> on_due);

  void begin_handshake() { handshake_due_ = Clock::now() + options_.handshake_timeout; }
  void end_handshake() { handshake_due_ = kNever; }
  /// A request is incomplete: its time runs from its first byte.
  void begin_request();
  void end_request() { request_due_ = kNever; }
  void begin_write() { write_due_ = Clock::now() + options_.write_timeout; }
  void end_write() { write_due_ = kNever; }
  /// The client has connected, or asked for something.
  void restart_idle();

  /// Sets the timer; `owner` stays alive until it fires.
  void watch(std::shared_ptr<const void> owner);
  /// The deadline that the client has missed, in words; empty = none. A client that waits for us is
  /// not idle.
  [[nodiscard]] std::string missed(bool waits_for_us);
  void close();

 private:
  static constexpr Clock::time_point kNever = Clock::time_point::max();

  const ModbusServerOptions& options_;
  std::function<void()> on_due_;
  boost::asio::steady_timer timer_;
  Clock::time_point handshake_due_ = kNever;
  Clock::time_point request_due_ = kNever, write_due_ = kNever, idle_due_ = kNever;
  Clock::time_point timer_at_ = kNever;
  bool closed_ = false;
};

}  // namespace aprsim::modbus_server
