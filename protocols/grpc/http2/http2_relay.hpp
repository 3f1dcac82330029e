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
  std::chrono::milliseconds stall_timeout{20000};  ///< ends a client that reads nothing for so long
  std::chrono::milliseconds handshake_timeout{5000};
  std::shared_ptr<protocols::Tls> tls = {};  ///< null = no encryption
  std::function<void(int fd)> hand_over;     ///< gives gRPC a connected socket
  std::function<void(Http2Relay&)> on_end;
  ConnectedClients* clients = nullptr;  ///< registry of the clients of the relays
};

/// Relay between one client's socket and gRPC, which has the other end of a socket pair. Forwards
/// bytes both ways, one buffer at a time, while the guard accepts them. TLS ends here, so that the
/// guard sees plain bytes. Keeps itself alive while an operation is pending.
/// Thread: the listener's.
class Http2Relay : public std::enable_shared_from_this<Http2Relay> {
 public:
  using Socket = boost::asio::ip::tcp::socket;

  /// Rules, log and backoff must outlive it.
  Http2Relay(Socket client, std::string peer, protocols::ConnectionLimiter::Slot slot,
             protocols::ConnectionTrace trace, const RelayRules& rules, protocols::LimitedLog& log,
             Backoff& backoff);

  void start();
  /// Ends when gRPC has closed its end.
  void drain();
  /// Closes at once.
  void close();
  /// The same, to make room for a new client.
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
  /// Ends it. `between_frames`: the bytes sent to the client end with a whole frame.
  void refuse(const std::string& why, bool between_frames);
  void read_rest();

  /// The client has received the present replies: read the next ones of gRPC.
  void on_sent(bool failed);
  void await_taking();
  [[nodiscard]] Socket& socket() { return client_.next_layer(); }

  protocols::TlsStream<Socket> client_;
  boost::asio::local::stream_protocol::socket server_;
  const std::string peer_;
  std::string name_;  ///< of the socket that gRPC sees
  protocols::ConnectionLimiter::Slot slot_;
  protocols::ConnectionTrace trace_;
  std::string end_;        ///< the reason of its end
  std::size_t heard_ = 0;  ///< bytes received, up to the length of HTTP/2's preface
  const RelayRules& rules_;
  protocols::LimitedLog& log_;
  Backoff& backoff_;
  boost::asio::ip::address address_;
  Http2Guard guard_;
  boost::asio::steady_timer hear_timer_, stall_timer_;
  Buffer to_server_, to_client_;
  std::size_t rest_ = 0;   ///< bytes discarded after a refusal
  bool deaf_ = false;      ///< not read until gRPC has replied
  std::string last_word_;  ///< in flight after a refusal
  bool answering_ = false, waiting_ = false, refused_ = false, closed_ = false;
};

}  // namespace aprsim::grpc_server
