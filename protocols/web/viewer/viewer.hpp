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

/// The update as bytes for any number of viewers.
[[nodiscard]] WebMessage pack(const v1::ViewerUpdate& update);

/// One browser: its messages on their way, its subjects, its permissions. One write is under way at
/// a time. Thread: the server's.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  using Clock = std::chrono::steady_clock;
  struct Events {
    std::function<void(Viewer&, const v1::ViewerRequest&)> request;
    std::function<void(Viewer&)> end;  ///< once
  };

  Viewer(std::uint64_t id, std::shared_ptr<WebSocket> socket, std::string peer, Events events);

  void start();
  /// Must arrive: a viewer that leaves too many waiting is closed.
  void send(WebMessage message);
  void send(const v1::ViewerUpdate& update) { send(pack(update)); }
  /// May be left out; false when it was.
  bool send_if_quick(WebMessage message);
  /// Each slot keeps its latest message, behind all that must arrive; lower slots go first. False
  /// when it takes the place of one that waited.
  bool send_latest(std::size_t slot, WebMessage message);
  void close(const std::string& why, bool fault = false);
  void drop() { socket_->drop(); }

  /// Whether the rate that this viewer asked for lets it have a snapshot now.
  [[nodiscard]] bool due(Clock::time_point now);
  void set_rate(double hz);

  /// Nothing that must arrive is waiting.
  [[nodiscard]] bool idle() const { return queue_.empty() && !closed_; }

  [[nodiscard]] std::uint64_t id() const { return id_; }
  [[nodiscard]] const std::string& peer() const { return peer_; }

  protocols::ConnectionTrace trace;
  v1::Watch watch;
  protocols::Caller caller;
  protocols::Role role = protocols::Role::kNone;  ///< that it was told last
  bool shown = false;                             ///< it has what is sent once
  bool snapshot_due = false;                      ///< at this tick
  std::uint64_t skipped_snapshots = 0;
  std::shared_ptr<const void> cell;                ///< the description that it has
  std::vector<std::optional<std::uint64_t>> seen;  ///< revision of each topic that it has
  std::string recorded_jog;                        ///< the last of its jogs that was recorded

 private:
  void on_message(std::string_view data);
  void write_next();

  std::uint64_t id_;
  std::shared_ptr<WebSocket> socket_;
  std::string peer_;
  Events events_;
  protocols::RateLimit rate_;
  std::deque<WebMessage> queue_;
  std::map<std::size_t, WebMessage> latest_;  // by slot
  Clock::duration period_{};
  Clock::time_point next_{};
  bool writing_ = false, closed_ = false;
};

}  // namespace aprsim::web
