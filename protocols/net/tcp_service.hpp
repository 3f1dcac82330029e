#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/net/run_loop.hpp"
#include "protocols/net/tcp_listener.hpp"

namespace aprsim::protocols {

/// The common part of listeners over raw sockets: an io_context with its single thread, the
/// acceptor, the open connections, and an orderly shutdown. For use inside a listener; do not
/// include it in other headers.
///
/// A `Connection` has start(); drain(), which sends pending replies and ends; close(), which ends
/// at once; evict(), which ends at once in favour of a new client; and slot(). At its end it calls
/// ended() of its service once.
///
/// The owner destroys it, or calls stop(), before the objects that the connections refer to.
template <typename Connection>
class TcpService {
 public:
  using Make = std::function<std::shared_ptr<Connection>(TcpListener::Socket, std::string peer,
                                                         TcpListener::Slot slot)>;

  /// `make` wraps an accepted socket. Connections that still drain at the deadline are closed.
  TcpService(std::string name, const ListenerOptions& options, Make make)
      : name_(std::move(name)),
        drain_deadline_(options.drain_deadline),
        make_(std::move(make)),
        work_(io_.get_executor()),
        listener_(io_, name_, options,
                  [this](TcpListener::Socket socket, std::string peer, TcpListener::Slot slot) {
                    connect(make_, std::move(socket), std::move(peer), std::move(slot));
                  }),
        drain_timer_(io_) {}
  ~TcpService() { stop(); }
  TcpService(const TcpService&) = delete;
  TcpService& operator=(const TcpService&) = delete;

  [[nodiscard]] boost::asio::io_context& io() { return io_; }
  [[nodiscard]] const TcpListener& listener() const { return listener_; }

  // Thread: the owner's.

  /// One more port, served by the same thread. The owner calls its listen() before start().
  [[nodiscard]] TcpListener& add(std::string name, const ListenerOptions& options, Make make) {
    auto accept = [this, make = std::move(make)](TcpListener::Socket socket, std::string peer,
                                                 TcpListener::Slot slot) {
      connect(make, std::move(socket), std::move(peer), std::move(slot));
    };
    others_.push_back(
        std::make_unique<TcpListener>(io_, std::move(name), options, std::move(accept)));
    return *others_.back();
  }
  /// Binds; connections wait until start(). Returns the port.
  [[nodiscard]] Result<std::uint16_t> listen() { return listener_.listen(); }
  void start() {
    thread_ = std::thread([this] { run_loop(io_, name_); });
  }
  /// Accepts no more connections; open ones continue.
  void stop_accepting() {
    boost::asio::post(io_, [this] { close_listeners(); });
  }
  /// Drains and waits for the end. `on_drain` cancels, on the service's thread, the owner's other
  /// pending work there. No effect unless the service runs.
  void stop(std::function<void()> on_drain = [] {}) {
    if (!thread_.joinable()) return;
    boost::asio::post(io_, [this, &on_drain] { drain(on_drain); });
    thread_.join();
  }

  // Thread: the service's.

  [[nodiscard]] bool draining() const { return draining_; }
  /// Refuses connections, or accepts them again on the same port.
  void refuse_connections(bool refuse) {
    if (draining_) return;
    const auto set = [refuse](TcpListener& listener) {
      if (refuse) {
        listener.suspend();
      } else {
        listener.resume();
      }
    };
    set(listener_);
    for (const auto& other : others_) set(*other);
  }
  void ended(Connection& connection) {
    connection.slot().leave();
    connections_.erase(&connection);
    finish_if_drained();
  }
  /// A connection may end while it is visited.
  template <typename Visit>
  void for_each(const Visit& visit) {
    std::vector<std::shared_ptr<Connection>> all;
    for (const auto& [key, connection] : connections_) all.push_back(connection);
    for (const auto& connection : all) visit(*connection);
  }

 private:
  void connect(const Make& make, TcpListener::Socket socket, std::string peer,
               TcpListener::Slot slot) {
    const auto connection = make(std::move(socket), std::move(peer), std::move(slot));
    connections_[connection.get()] = connection;
    connection->slot().on_evict([weak = std::weak_ptr<Connection>(connection)] {
      if (const auto open = weak.lock()) open->evict();
    });
    try {
      connection->start();
    } catch (...) {
      connections_.erase(connection.get());
      throw;
    }
  }

  void close_listeners() {
    listener_.close();
    for (const auto& other : others_) other->close();
  }

  void drain(const std::function<void()>& on_drain) {
    draining_ = true;
    close_listeners();
    on_drain();
    drain_timer_.expires_after(drain_deadline_);
    drain_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) for_each([](Connection& connection) { connection.close(); });
    });
    for_each([](Connection& connection) { connection.drain(); });
    finish_if_drained();
  }

  void finish_if_drained() {
    if (!draining_ || !connections_.empty()) return;
    drain_timer_.cancel();
    work_.reset();
  }

  const std::string name_;
  const std::chrono::milliseconds drain_deadline_;
  const Make make_;
  boost::asio::io_context io_{1};
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  TcpListener listener_;
  std::vector<std::unique_ptr<TcpListener>> others_;
  std::map<const Connection*, std::shared_ptr<Connection>> connections_;
  boost::asio::steady_timer drain_timer_;
  bool draining_ = false;
  std::thread thread_;
};

}  // namespace aprsim::protocols
