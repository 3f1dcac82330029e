#pragma once

#include <bitset>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/ip/tcp.hpp>

#include "protocols/modbus/connection_record.hpp"
#include "protocols/modbus/deadlines.hpp"
#include "protocols/modbus/listener_context.hpp"
#include "protocols/modbus/reply_queue.hpp"
#include "protocols/modbus/request_executor.hpp"
#include "protocols/modbus/request_reader.hpp"
#include "protocols/modbus/security/client_rights.hpp"
#include "protocols/net/connection_limiter.hpp"
#include "protocols/net/time_pacer.hpp"
#include "protocols/net/tls_stream.hpp"
#include "world/base/rate_limit.hpp"

namespace aprsim::modbus_server {

/// One client, after its TLS handshake where the port has one: reads bytes, validates each request
/// and replies in the order of the requests. Memory is bounded, nothing waits for the peer, and a
/// stalled peer is dropped. Thread: the listener's.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Clock = std::chrono::steady_clock;

  Connection(boost::asio::ip::tcp::socket socket, std::string peer,
             protocols::ConnectionLimiter::Slot slot, ListenerContext& context);

  void start();
  /// Replies to the pending write, sends ready replies, then closes. Accepts no more requests.
  void drain();
  /// Ends the connection now; `fault`: because of the peer's fault.
  void close(std::string_view why, bool fault);
  void close() { close("the server stops", false); }
  void evict() { close("evicted for a new client", true); }
  [[nodiscard]] protocols::ConnectionLimiter::Slot& slot() { return slot_; }
  /// Checks whether the pending write has been applied or has timed out. False: done.
  [[nodiscard]] bool poll_applied(Clock::time_point now);

 private:
  void begin_handshake();
  void on_handshake(const boost::system::error_code& error);
  void read();
  void on_read(std::size_t size);
  void on_end_of_stream(const boost::system::error_code& error);
  void process();
  [[nodiscard]] bool follow_peer();
  [[nodiscard]] bool admits(const modbus::ValidatedRequest& validated);
  [[nodiscard]] std::string refusal_of(const modbus::ValidatedRequest& validated);
  [[nodiscard]] bool may_process_request() const;
  [[nodiscard]] bool is_stop(const modbus::ValidatedRequest& validated) const;
  [[nodiscard]] bool process_request();
  void take(const modbus::ValidatedRequest& validated);
  void break_stream(std::string_view reason);
  [[nodiscard]] bool close_if_finished();
  void join_time();
  /// For a pacing client: its writes take effect now, and the reply follows a poll period later.
  void take_time(const modbus::ValidatedRequest& validated);
  void execute(const modbus::ValidatedRequest& validated);
  void finish_write_in_time();
  /// Sends a reply to the peer, subject to injected faults.
  void reply(std::vector<std::uint8_t> adu);
  void write();
  void on_written(const boost::system::error_code& error);
  void on_deadline();

  protocols::TlsStream<boost::asio::ip::tcp::socket> stream_;
  const std::string peer_;
  protocols::ConnectionLimiter::Slot slot_;
  ListenerContext& context_;
  ConnectionRecord record_;
  ClientRights rights_;
  std::bitset<256> refused_functions_;  // whose refusal was logged
  Deadlines deadlines_;
  protocols::RateLimit rate_;
  RequestReader reader_;
  RequestExecutor executor_;
  ReplyQueue replies_;
  protocols::TimePacer pacer_;  // nothing is sent while it waits
  bool ready_ = false;          // for requests: no handshake is left
  bool reading_ = false, scheduled_ = false;
  bool ended_ = false, draining_ = false, closed_ = false;
  bool peer_closed_ = false;  // it has closed; unread requests may be left
  int last_writes_ = 0;       // writes still taken from it then
  std::string_view broken_;   // why the stream cannot be framed; empty while it can
};

}  // namespace aprsim::modbus_server
