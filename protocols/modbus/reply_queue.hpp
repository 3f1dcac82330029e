#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <boost/asio/any_io_executor.hpp>

#include "protocols/net/delayed_replies.hpp"

namespace aprsim::modbus_server {

/// Replies to one client in the order of its requests: delayed, ready, and being written. Thread:
/// the executor's.
class ReplyQueue {
 public:
  using Bytes = std::vector<std::uint8_t>;
  struct Events {
    std::function<void(std::span<const std::uint8_t>)> ready;  ///< these are ready to be written
    std::function<void()> go_on;  ///< delayed replies have become ready
  };

  ReplyQueue(const boost::asio::any_io_executor& io, Events events)
      : events_(events),
        delayed_(io, {[this](const Bytes& bytes) { add_ready(bytes); }, events.go_on}) {}

  /// `owner` stays alive while replies are delayed.
  void add(Bytes bytes, std::chrono::nanoseconds delay, std::shared_ptr<const void> owner) {
    if (!delayed_.must_wait(delay)) return add_ready(bytes);
    const std::size_t size = bytes.size();
    delayed_.add(std::move(bytes), size, delay, std::move(owner));
  }
  [[nodiscard]] std::size_t bytes() const {
    return ready_.size() + writing_.size() + delayed_.bytes();
  }
  [[nodiscard]] bool empty() const {
    return ready_.empty() && writing_.empty() && delayed_.empty();
  }
  /// All ready replies, until end_write(); empty if there are none or a write is pending.
  [[nodiscard]] std::span<const std::uint8_t> begin_write() {
    if (!writing_.empty()) return {};
    std::swap(ready_, writing_);
    return writing_;
  }
  void end_write() { writing_.clear(); }
  void close() { delayed_.close(); }

 private:
  void add_ready(const Bytes& bytes) {
    ready_.insert(ready_.end(), bytes.begin(), bytes.end());
    events_.ready(bytes);
  }

  Events events_;
  Bytes ready_, writing_;
  protocols::DelayedReplies<Bytes> delayed_;
};

}  // namespace aprsim::modbus_server
