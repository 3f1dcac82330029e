#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/net/allow_list.hpp"
#include "protocols/net/connection_places.hpp"
#include "protocols/ports/refusal_sink.hpp"
#include "world/base/result.hpp"

namespace aprsim::protocols {

struct TcpListenerOptions {
  std::string name;         ///< of the listener, for log lines
  std::string address;      ///< numeric IPv4 or IPv6
  std::uint16_t port = 0;   ///< 0 = any free port
  ConnectionLimits limits;  ///< a connection without a place is given to on_refused
  /// Networks whose clients are served; the others' connections are closed at once. Empty =
  /// everybody's are.
  std::vector<std::string> allow = {};
  RefusalSink* refusals = nullptr;  ///< hears of connections that are refused; outlives it
  /// What takes over the socket of a connection without a place; null = it is closed.
  std::function<void(boost::asio::ip::tcp::socket, const std::string& peer)> on_refused = {};
};

/// Accepts TCP connections for a protocol: binds, gives each a place or refuses it, survives
/// running out of descriptors or memory, prepares each socket (no Nagle delay, keepalive). Accepts
/// several at a time, so that a newcomer behind many others waits for few turns of the loop. For
/// use inside a listener; its header stays out of other headers. Thread: the io_context's single
/// one.
class TcpListener {
 public:
  using Socket = boost::asio::ip::tcp::socket;
  using Place = ConnectionPlaces::Place;
  /// Owns an accepted socket and its place from now on; `peer` is "address:port". What it throws
  /// costs this connection only.
  using OnAccept = std::function<void(Socket socket, std::string peer, Place place)>;

  TcpListener(boost::asio::io_context& io, TcpListenerOptions options, OnAccept on_accept);

  /// Binds and starts to accept once the io_context runs. Returns the port. Errors name address,
  /// port and cause.
  [[nodiscard]] Result<std::uint16_t> listen();
  void close();
  /// Refuses connections until resume(), as a machine does on which nothing listens.
  void suspend() { close(); }
  /// Listens again on the same port, as soon as that is possible.
  void resume();

  // Thread: any.
  [[nodiscard]] std::size_t open() const { return places_->open(); }
  [[nodiscard]] std::uint64_t accepted() const { return accepted_; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  void accept();
  void accept_waiting();
  void admit(Socket socket);
  void refuse(const std::string& peer, const std::string& why);
  void retry_later(const std::string& why);

  TcpListenerOptions options_;
  AllowList allow_;
  OnAccept on_accept_;
  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer retry_;
  std::shared_ptr<ConnectionPlaces> places_;
  std::atomic<std::uint64_t> accepted_{0}, refused_{0};
  std::uint64_t refused_unlogged_ = 0;
  std::chrono::steady_clock::time_point last_refusal_log_{}, last_failure_log_{};
};

}  // namespace aprsim::protocols
