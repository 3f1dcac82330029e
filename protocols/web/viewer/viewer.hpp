#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "aprsim/v1/web.pb.h"
#include "protocols/access/access.hpp"
#include "protocols/record/wire_trace.hpp"
#include "protocols/web/http/web_socket.hpp"
#include "world/base/rate_limit.hpp"

namespace aprsim::web {

/// One browser: what waits for it, what it watches, what it may. One write is under way at a time;
/// of snapshots and register values only the latest waits. Thread: the server's.
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
  /// May be left out; false when it was.
  bool send_if_quick(WebMessage message);
  /// False when the one before was left out.
  bool offer_snapshot(WebMessage message);
  void offer_registers(WebMessage message) { offer(registers_, std::move(message)); }
  void close(const std::string& why, bool fault = false);
  void drop() { socket_->drop(); }

  /// Whether the rate that this viewer asked for lets it have a snapshot now.
  [[nodiscard]] bool due(Clock::time_point now);
  void set_rate(double hz);

  /// Nothing that must arrive is waiting.
  [[nodiscard]] bool idle() const { return queue_.empty() && !closed_; }

  [[nodiscard]] std::uint64_t id() const { return id_; }
  [[nodiscard]] const std::string& peer() const { return peer_; }
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }

  protocols::ConnectionTrace trace;
  v1::Watch watch;
  protocols::Caller caller;
  protocols::Role role = protocols::Role::kNone;  ///< that it was told last
  bool shown = false;                             ///< it has what is sent once
  std::shared_ptr<const void> cell;               ///< the description that it has
  WebMessage looks;                               ///< that it has
  struct Next {
    std::uint64_t crcl = 1, modbus = 1;           ///< numbers of the events that it is to get next
    std::uint64_t faults = ~std::uint64_t{0};     ///< revision of the list that it has
    std::uint64_t bookmarks = ~std::uint64_t{0};  ///< the same
  } next_events;
  std::shared_ptr<const void> programs;  ///< the status that it has
  std::string noted;                     ///< what was last noted of its jog

 private:
  void on_message(std::string_view data);
  void offer(WebMessage& slot, WebMessage message);
  void write_next();

  std::uint64_t id_;
  std::shared_ptr<WebSocket> socket_;
  std::string peer_;
  Events events_;
  protocols::RateLimit rate_;
  std::deque<WebMessage> queue_;
  WebMessage snapshot_, registers_;
  Clock::duration period_{};
  Clock::time_point next_{};
  std::uint64_t skipped_ = 0;
  bool writing_ = false, closed_ = false;
};

}  // namespace aprsim::web
