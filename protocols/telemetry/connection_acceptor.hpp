#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "protocols/connection_places.hpp"
#include "protocols/limited_log.hpp"
#include "world/api/error.hpp"

namespace aprsim::telemetry {

/// A listening TCP socket with a thread that accepts connections, each if there is a place for it,
/// and hands the connected sockets on.
///
/// gRPC's own acceptor has no limit and, in 1.51, stops for good after running out of descriptors
/// (CVE-2023-4785); this one closes what is too much and goes on. The address is never shared with
/// another process (no SO_REUSEPORT).
class ConnectionAcceptor {
 public:
  /// Takes over a connected, non-blocking socket and closes it some day. What it throws costs this
  /// connection only.
  using Handler = std::function<void(int fd)>;

  explicit ConnectionAcceptor(protocols::ConnectionLimits limits)
      : places_(protocols::ConnectionPlaces::create(limits)) {}
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
  /// Connections closed at once for want of a place.
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  /// A handed-on socket: its number may come to mean another one, its cookie never does.
  struct Connection {
    int fd = -1;
    std::uint64_t cookie = 0;
    protocols::ConnectionPlaces::Place place;
  };
  void loop();
  bool accept_one();
  void admit(int fd, const std::string& peer);
  void forget_ended();
  void look_at_use();

  Handler handler_;
  protocols::LimitedLog log_{"grpc"};
  int listen_fd_ = -1;
  int stop_fd_ = -1;
  std::mutex mutex_;
  std::shared_ptr<protocols::ConnectionPlaces> places_;  // under mutex_, and so are these:
  std::vector<Connection> connections_;
  std::atomic<std::uint64_t> refused_{0};
  std::thread thread_;
};

}  // namespace aprsim::telemetry
