#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/net/connection_limiter.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/record/connection_trace.hpp"
#include "protocols/vision/vision_server.hpp"

namespace aprsim::vision_server {

/// Counters of a server's connections together, for any thread to read.
struct VisionCounters {
  std::atomic<std::uint64_t> dropped{0}, skipped{0};
};

/// One frame, shared by all connections that send it.
using VisionLine = std::shared_ptr<const std::string>;

/// One client's socket. It sends whole lines; while one is being sent, only the latest of the new
/// lines is kept. Input is discarded; a browser's input closes the connection. A client that has
/// finished sending still gets lines. Keeps itself alive while an operation is pending. Thread: the
/// server's.
class VisionConnection : public std::enable_shared_from_this<VisionConnection> {
 public:
  using OnEnd = std::function<void(VisionConnection&)>;

  /// `on_idle` is called when no offered line is left; `on_end` is called once, when the socket has
  /// been closed.
  VisionConnection(boost::asio::ip::tcp::socket socket, protocols::LimitedLog& log,
                   std::string peer, protocols::ConnectionLimiter::Slot slot,
                   protocols::ConnectionTrace trace, const VisionServerOptions& options,
                   VisionCounters& counters, std::function<void()> on_idle, OnEnd on_end);

  void start();
  void offer(VisionLine line);
  /// Whether an offered line is not yet being sent.
  [[nodiscard]] bool busy() const { return sending_ && !closed_; }
  /// Closes after the line that is being sent.
  void drain();
  /// Closes at once.
  void close();
  void evict() { drop("evicted for a new client"); }
  [[nodiscard]] protocols::ConnectionLimiter::Slot& slot() { return slot_; }

 private:
  void read();
  void on_read(std::size_t size);
  void drop(const std::string& why);
  void send_next();
  void write();
  void on_write(const boost::system::error_code& error, std::size_t size);

  boost::asio::ip::tcp::socket socket_;
  protocols::LimitedLog& log_;
  std::string peer_;
  protocols::ConnectionLimiter::Slot slot_;
  protocols::ConnectionTrace trace_;
  std::string end_ = "the server stops";  // why it ends
  const VisionServerOptions& options_;
  VisionCounters& counters_;
  std::function<void()> on_idle_;
  OnEnd on_end_;
  boost::asio::steady_timer write_timer_;
  std::array<char, 1024> input_{};
  VisionLine sending_, next_;
  std::size_t sent_ = 0;  // of sending_
  bool heard_ = false;    // anything yet
  bool draining_ = false, closed_ = false;
};

}  // namespace aprsim::vision_server
