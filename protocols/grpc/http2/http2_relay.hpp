#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/grpc/calls/connected_clients.hpp"
#include "protocols/grpc/http2/backoff.hpp"
#include "protocols/grpc/http2/http2_guard.hpp"
#include "protocols/net/connection_limiter.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/net/tls.hpp"
#include "protocols/net/tls_stream.hpp"
#include "protocols/record/connection_trace.hpp"

namespace aprsim::grpc_server {

class Http2Relay;

/// Settings that the relays of a listener share.
struct RelayRules {
  Http2Limits limits;
  Http2Limits backoff_limits{.resets_per_s = 10, .reset_burst = 20};
  std::chrono::milliseconds stall_timeout{20000};  ///< a client that takes nothing for so long goes
  std::chrono::milliseconds handshake_timeout{5000};
  std::shared_ptr<protocols::Tls> tls = {};  ///< null = nothing is encrypted
  std::function<void(int fd)> hand_over;     ///< gives gRPC a connected socket
  std::function<void(Http2Relay&)> on_end;
  ConnectedClients* clients = nullptr;  ///< where the relays say whom they serve
};

/// Between one client's socket and gRPC, which gets the other end of a socket pair: passes bytes
/// both ways, a buffer at a time, as long as the guard finds nothing wrong with them. TLS ends
/// here, so that the guard sees what it encrypts. Keeps itself alive while an operation is pending.
/// Thread: the listener's.
class Http2Relay : public std::enable_shared_from_this<Http2Relay> {
 public:
  using Socket = boost::asio::ip::tcp::socket;

  /// Rules, log and backoff must outlive it.
  Http2Relay(Socket client, std::string peer, protocols::ConnectionLimiter::Slot slot,
             protocols::ConnectionTrace trace, const RelayRules& rules, protocols::LimitedLog& log,
             Backoff& backoff);

  void start();
  /// Goes on until gRPC has closed its end.
  void drain();
  /// Closes at once.
  void close();
  /// The same for a newcomer's sake.
  void evict();
  [[nodiscard]] protocols::ConnectionLimiter::Slot& slot() { return slot_; }

 private:
  using Buffer = std::array<char, 16'384>;
  void wait_for_turn();
  [[nodiscard]] bool client_has_gone();
  void shake_hands();
  void connect();
  [[nodiscard]] int make_pair();
  void hear();
  void read_client();
  void on_client(std::size_t size);
  void read_server();
  void on_server(std::size_t size);
  /// Ends it. `between_frames`: what the client has been sent ends with a whole frame.
  void refuse(const std::string& why, bool between_frames);
  void read_rest();

  /// Answers the client has been sent on: gRPC's next ones.
  void on_sent(bool failed);
  void await_taking();
  [[nodiscard]] Socket& socket() { return client_.next_layer(); }

  protocols::TlsStream<Socket> client_;
  boost::asio::local::stream_protocol::socket server_;
  const std::string peer_;
  std::string name_;  ///< of the socket that gRPC sees
  protocols::ConnectionLimiter::Slot slot_;
  protocols::ConnectionTrace trace_;
  std::string end_;        ///< why it ends
  std::size_t heard_ = 0;  ///< bytes, up to those of HTTP/2's preface
  const RelayRules& rules_;
  protocols::LimitedLog& log_;
  Backoff& backoff_;
  boost::asio::ip::address address_;
  Http2Guard guard_;
  boost::asio::steady_timer hear_timer_, stall_timer_;
  Buffer to_server_, to_client_;
  std::size_t rest_ = 0;   ///< bytes thrown away after a refusal
  bool deaf_ = false;      ///< not heard until gRPC has answered
  std::string last_word_;  ///< on its way after a refusal
  bool answering_ = false, waiting_ = false, refused_ = false, closed_ = false;
};

}  // namespace aprsim::grpc_server
