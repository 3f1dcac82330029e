#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "world/api/error.hpp"

namespace aprsim::telemetry {

/// A listening TCP socket with a thread that accepts and hands on connected sockets, never more
/// than a fixed number at once.
///
/// gRPC's own acceptor has no limit and, in 1.51, stops for good after running out of descriptors
/// (CVE-2023-4785); this one closes what is too much and goes on. The address is never shared with
/// another process (no SO_REUSEPORT).
class ConnectionAcceptor {
 public:
  /// Takes over a connected, non-blocking socket and closes it some day.
  using Handler = std::function<void(int fd)>;

  explicit ConnectionAcceptor(int max_connections) : max_connections_(max_connections) {}
  ~ConnectionAcceptor();
  ConnectionAcceptor(const ConnectionAcceptor&) = delete;
  ConnectionAcceptor& operator=(const ConnectionAcceptor&) = delete;

  /// Binds and listens; port 0 = any free one. Returns the bound port.
  /// Errors: kInvalidArgument for an address that is not numeric, kUnavailable for the rest.
  [[nodiscard]] Result<std::uint16_t> listen(const std::string& address, std::uint16_t port);
  /// Begins to accept.
  void run(Handler handler);
  /// Closes the listening socket and ends the thread. Handed-on sockets stay open.
  void stop();

  /// Connections open now. Thread: any.
  [[nodiscard]] std::size_t open();
  /// Connections closed at once because there were too many.
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  /// A handed-on socket: its number may come to mean another one, its cookie never does.
  struct Connection {
    int fd = -1;
    std::uint64_t cookie = 0;
  };
  void loop();
  bool accept_one();

  const int max_connections_;
  Handler handler_;
  int listen_fd_ = -1;
  int stop_fd_ = -1;
  std::mutex mutex_;
  std::vector<Connection> connections_;  // under mutex_
  std::atomic<std::uint64_t> refused_{0};
  std::thread thread_;
};

}  // namespace aprsim::telemetry
