#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace aprsim::protocols {

/// One document, request or reply on a wire.
struct WireEvent {
  std::string source;  ///< listener, "crcl.fanuc"
  std::string peer;    ///< address and port
  bool from_client = false;
  std::chrono::system_clock::time_point time;
  std::string type;      ///< "MoveToType"; empty for Modbus
  std::int64_t id = 0;   ///< CommandID or transaction
  std::string state;     ///< of a status
  double latency_s = 0;  ///< of a reply, since its request
  std::string data;      ///< as on the wire
};

/// Carries what listeners see to whoever watches, without ever making a listener wait for it: the
/// oldest events are given up when nobody fetches them. While nobody watches a listener pays for
/// one relaxed load. Thread: any.
class WireTap {
 public:
  static constexpr std::size_t kMaxEvents = 2048;
  static constexpr std::size_t kMaxBytes = std::size_t{4} << 20;

  [[nodiscard]] bool watched() const { return watched_.load(std::memory_order_relaxed); }

  /// Turning it off forgets what is kept.
  void watch(bool on) {
    if (watched_.exchange(on) == on || on) return;
    const std::lock_guard lock(mutex_);
    events_.clear();
    bytes_ = dropped_ = 0;
  }

  void note(WireEvent event) {
    const std::lock_guard lock(mutex_);
    bytes_ += event.data.size();
    events_.push_back(std::move(event));
    while (events_.size() > kMaxEvents || bytes_ > kMaxBytes) {
      bytes_ -= events_.front().data.size();
      events_.pop_front();
      ++dropped_;
    }
  }

  /// Moves up to `limit` of the oldest events into `out`; returns how many were given up since the
  /// last call.
  std::uint64_t fetch(std::size_t limit, std::vector<WireEvent>& out) {
    const std::lock_guard lock(mutex_);
    for (; limit > 0 && !events_.empty(); --limit) {
      bytes_ -= events_.front().data.size();
      out.push_back(std::move(events_.front()));
      events_.pop_front();
    }
    return std::exchange(dropped_, 0);
  }

 private:
  std::atomic<bool> watched_{false};
  std::mutex mutex_;
  std::deque<WireEvent> events_;
  std::size_t bytes_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace aprsim::protocols
