#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/net/allow_list.hpp"
#include "protocols/net/listener_options.hpp"
#include "world/base/result.hpp"

namespace aprsim::protocols {

/// Accepts TCP connections for a protocol: binds, gives each connection a slot or refuses it,
/// survives exhausted descriptors and memory, and configures each socket (no Nagle delay,
/// keepalive). Accepts several connections a turn of the loop, so that a burst of clients is
/// accepted in few turns. For use inside a listener; do not include it in other headers. Thread:
/// the io_context's single one.
class TcpListener {
 public:
  using Socket = boost::asio::ip::tcp::socket;
  using Slot = ConnectionLimiter::Slot;
  /// Takes ownership of an accepted socket and its slot; `peer` is "address:port". An exception
  /// ends this connection only.
  using OnAccept = std::function<void(Socket socket, std::string peer, Slot slot)>;
  /// Takes ownership of the socket of a connection without a slot; null = it is closed.
  using OnRefused = std::function<void(Socket socket, const std::string& peer)>;

  /// `name` is the listener's name in log lines and errors.
  TcpListener(boost::asio::io_context& io, std::string name, ListenerOptions options,
              OnAccept on_accept, OnRefused on_refused = {});

  /// Binds and starts to accept once the io_context runs. Returns the port. Errors name address,
  /// port and cause.
  [[nodiscard]] Result<std::uint16_t> listen();
  void close();
  /// Refuses connections until resume(), as if nothing listened on the port.
  void suspend() { close(); }
  /// Listens again on the same port; retries until that succeeds.
  void resume();

  // Thread: any.
  [[nodiscard]] std::size_t open() const { return limiter_->open(); }
  [[nodiscard]] std::uint64_t accepted() const { return accepted_; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  using Acceptor = boost::asio::ip::tcp::acceptor;
  /// Binds each address at one port, and returns it.
  [[nodiscard]] Result<std::uint16_t> bind_all(std::span<const boost::asio::ip::address> addresses);
  void accept(Acceptor& acceptor);
  void accept_waiting(Acceptor& acceptor);
  void admit(Socket socket);
  void refuse(const std::string& peer, const std::string& why);
  void retry_later(Acceptor& acceptor, const std::string& why);

  const std::string name_;
  ListenerOptions options_;
  AllowList allow_;
  OnAccept on_accept_;
  OnRefused on_refused_;
  std::array<Acceptor, 2> acceptors_;  ///< the second one for localhost
  boost::asio::steady_timer retry_;
  std::shared_ptr<ConnectionLimiter> limiter_;
  std::atomic<std::uint64_t> accepted_{0}, refused_{0};
  std::uint64_t refused_unlogged_ = 0;
  std::chrono::steady_clock::time_point last_refusal_log_{}, last_failure_log_{};
};

}  // namespace aprsim::protocols
