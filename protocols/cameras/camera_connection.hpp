#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/cameras/camera_request.hpp"
#include "protocols/cameras/camera_server.hpp"
#include "protocols/net/connection_limiter.hpp"
#include "protocols/net/limited_log.hpp"

namespace aprsim::camera_server {

/// Counters of a server's connections together, for any thread to read.
struct CameraCounters {
  std::atomic<std::uint64_t> dropped{0}, skipped{0};
};

/// A picture, shared by all connections that send it.
using Jpeg = std::shared_ptr<const std::string>;

/// One client's socket: one request, then pictures. While one is being sent, only the latest of
/// the new ones is kept. Keeps itself alive while an operation is pending. Thread: the server's.
class CameraConnection : public std::enable_shared_from_this<CameraConnection> {
 public:
  using OnEnd = std::function<void(CameraConnection&)>;

  /// `on_wanted` is called when it waits for a picture; `on_end` once, when the socket has
  /// been closed.
  CameraConnection(boost::asio::ip::tcp::socket socket, protocols::LimitedLog& log,
                   std::string peer, protocols::ConnectionLimiter::Slot slot,
                   const CameraServerOptions& options, CameraCounters& counters,
                   std::function<void()> on_wanted, OnEnd on_end);

  void start();
  /// Whether it could send a picture now.
  [[nodiscard]] bool waits() const { return wants_ && !busy_ && !closed_; }
  void offer(const Jpeg& picture);
  void drain() { close(); }
  void close();
  void evict() { drop("evicted for a new client"); }
  [[nodiscard]] protocols::ConnectionLimiter::Slot& slot() { return slot_; }

 private:
  void read();
  void on_read(std::size_t size);
  void answer();
  void drop(const std::string& why);
  void send(std::string head, Jpeg picture);
  void write();
  void on_sent();
  void set_deadline();

  boost::asio::ip::tcp::socket socket_;
  protocols::LimitedLog& log_;
  std::string peer_;
  protocols::ConnectionLimiter::Slot slot_;
  const CameraServerOptions& options_;
  CameraCounters& counters_;
  std::function<void()> on_wanted_;
  OnEnd on_end_;
  boost::asio::steady_timer deadline_;
  std::array<char, 1024> input_{};
  std::string head_;
  CameraRequest request_;
  bool answered_ = false;  // the request has been read
  bool wants_ = false;     // pictures
  bool busy_ = false;      // sending
  bool last_ = false;      // what is being sent ends the connection
  bool closed_ = false;
  std::string sending_head_;
  Jpeg sending_, next_;
};

}  // namespace aprsim::camera_server
