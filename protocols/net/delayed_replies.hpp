#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <utility>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>

namespace aprsim::protocols {

/// Replies that an injected fault delays. They are sent in their order, each at its time; no later
/// reply overtakes them. Thread: the executor's.
template <typename Reply>
class DelayedReplies {
 public:
  using Clock = std::chrono::steady_clock;
  struct Events {
    std::function<void(Reply)> send;  ///< one reply that is due; it may call close()
    std::function<void()> sent;       ///< after all that were due together, unless closed
  };

  DelayedReplies(const boost::asio::any_io_executor& io, Events events)
      : events_(std::move(events)), timer_(io) {}

  /// Whether a reply has to wait for its own delay or behind others.
  [[nodiscard]] bool must_wait(std::chrono::nanoseconds delay) const {
    return delay.count() > 0 || !empty();
  }
  /// `bytes` is the reply's share of bytes(); `owner` stays alive while replies wait.
  void add(Reply reply, std::size_t bytes, std::chrono::nanoseconds delay,
           std::shared_ptr<const void> owner) {
    bytes_ += bytes;
    waiting_.push_back({Clock::now() + delay, std::move(reply), bytes});
    if (waiting_.size() == 1) wait(std::move(owner));
  }
  [[nodiscard]] bool empty() const { return waiting_.empty(); }
  /// The sum over all waiting replies.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  /// Drops all waiting replies and sends nothing from now on.
  void close() {
    closed_ = true;
    waiting_.clear();
    bytes_ = 0;
    timer_.cancel();
  }

 private:
  struct Waiting {
    Clock::time_point due;
    Reply reply;
    std::size_t bytes;
  };

  void wait(std::shared_ptr<const void> owner) {
    timer_.expires_at(waiting_.front().due);
    timer_.async_wait(
        [this, owner = std::move(owner)](const boost::system::error_code& cancelled) mutable {
          if (!cancelled && !closed_) send_due(std::move(owner));
        });
  }

  void send_due(std::shared_ptr<const void> owner) {
    while (!waiting_.empty() && waiting_.front().due <= Clock::now()) {
      Waiting due = std::move(waiting_.front());
      waiting_.pop_front();
      bytes_ -= due.bytes;
      events_.send(std::move(due.reply));
      if (closed_) return;
    }
    if (!waiting_.empty()) wait(owner);
    events_.sent();
  }

  Events events_;
  std::deque<Waiting> waiting_;
  std::size_t bytes_ = 0;
  boost::asio::steady_timer timer_;
  bool closed_ = false;
};

}  // namespace aprsim::protocols
