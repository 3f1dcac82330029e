#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aprsim/v1/web.pb.h"
#include "protocols/access/access.hpp"
#include "protocols/record/connection_trace.hpp"
#include "protocols/web/http/web_socket.hpp"
#include "world/base/rate_limit.hpp"

namespace aprsim::web {

/// Serialises an update once for any number of viewers.
[[nodiscard]] WebMessage pack(const v1::ViewerUpdate& update);

/// One browser: its outgoing messages, subscriptions and permissions. At most one write is pending.
/// Thread: the server's.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  using Clock = std::chrono::steady_clock;
  struct Events {
    std::function<void(Viewer&, const v1::ViewerRequest&)> request;
    std::function<void(Viewer&)> end;  ///< once
  };

  Viewer(std::uint64_t id, std::shared_ptr<WebSocket> socket, std::string peer, Events events);

  void start();
  /// Sends a message that must arrive. A viewer that lets too many wait is closed.
  void send(WebMessage message);
  void send(const v1::ViewerUpdate& update) { send(pack(update)); }
  /// Sends a message unless others wait; false = not sent.
  bool send_if_quick(WebMessage message);
  /// Sends the latest message of a slot, after all that must arrive; lower slots first. False = it
  /// replaced a message that waited.
  bool send_latest(std::size_t slot, WebMessage message);
  void close(const std::string& why, bool fault = false);
  void drop() { socket_->drop(); }

  /// Whether a snapshot is due now at this viewer's rate.
  [[nodiscard]] bool due(Clock::time_point now);
  void set_rate(double hz);

  /// Bytes of the messages that wait or are being sent. Viewers may share messages.
  [[nodiscard]] std::size_t waiting_bytes() const { return waiting_bytes_; }

  /// Whether no message that must arrive is waiting.
  [[nodiscard]] bool idle() const { return queue_.empty() && !closed_; }

  [[nodiscard]] std::uint64_t id() const { return id_; }
  [[nodiscard]] const std::string& peer() const { return peer_; }

  protocols::ConnectionTrace trace;
  v1::Watch watch;
  protocols::Caller caller;
  protocols::Role role = protocols::Role::kNone;  ///< last one sent
  bool shown = false;                             ///< constant messages have been sent
  bool snapshot_due = false;                      ///< at this tick
  std::uint64_t skipped_snapshots = 0;
  std::shared_ptr<const void> cell;                ///< description sent last
  std::vector<std::optional<std::uint64_t>> seen;  ///< revision of each topic sent last
  std::string recorded_jog;                        ///< its last recorded jog

 private:
  void on_message(std::string_view data);
  void on_written();
  void write_next();

  std::uint64_t id_;
  std::shared_ptr<WebSocket> socket_;
  std::string peer_;
  Events events_;
  protocols::RateLimit rate_;
  std::deque<WebMessage> queue_;
  std::map<std::size_t, WebMessage> latest_;  // by slot
  std::size_t waiting_bytes_ = 0, writing_bytes_ = 0;
  Clock::duration period_{};
  Clock::time_point next_{};
  bool writing_ = false, closed_ = false;
};

}  // namespace aprsim::web
