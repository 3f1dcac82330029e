#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/net/connection_limiter.hpp"
#include "protocols/net/delayed_replies.hpp"
#include "protocols/simple_message/connection_record.hpp"
#include "protocols/simple_message/listener_context.hpp"

namespace aprsim::simple_message {

/// One client of one port: cuts its bytes into requests and sends whole messages, each in one
/// write. Memory is bounded, nothing waits for the peer, and a peer that takes nothing is dropped.
/// Thread: the listener's.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(boost::asio::ip::tcp::socket socket, std::string listener, std::string peer,
             protocols::ConnectionLimiter::Slot slot, Role role, ListenerContext& context);

  /// `refusal` is the reason for closing it at once; empty = it is served.
  void start_with(std::string refusal) { refusal_ = std::move(refusal); }
  void start();
  /// Sends what is queued, then closes. Takes no more requests.
  void drain() { finish("the server stops"); }
  void finish(std::string_view why);
  void close(std::string_view why, bool fault);
  void close() { close("the server stops", false); }
  void evict() { close("evicted for a new client", true); }
  [[nodiscard]] protocols::ConnectionLimiter::Slot& slot() { return slot_; }
  [[nodiscard]] Role role() const { return role_; }
  [[nodiscard]] const std::string& peer() const { return peer_; }

  /// Sends a reply, subject to injected faults.
  void reply(std::string message) { send(std::move(message), true); }
  /// Sends a state, unless the reader has not taken the one before.
  void send_state(std::string message);
  /// Offers requests to the owner until it takes no more.
  void process();
  /// Whether bytes wait for process().
  [[nodiscard]] bool has_bytes() const { return used_ < size_; }
  /// Notices the end of a peer that nothing is read from.
  void notice_end();
  /// Counts and records a request that is taken; `fault`: why it is not understood.
  void record_request(std::span<const std::uint8_t> request, std::string_view fault = {});

 private:
  [[nodiscard]] Port framing() const;
  void read();
  void on_read(std::size_t size);
  void compact();
  void send(std::string message, bool reply);
  void enqueue(std::string message);
  void write();
  void on_written(const boost::system::error_code& error);
  [[nodiscard]] std::size_t output_bytes() const { return queued_bytes_ + delayed_.bytes(); }
  [[nodiscard]] bool close_if_finished();

  boost::asio::ip::tcp::socket socket_;
  const std::string peer_;
  protocols::ConnectionLimiter::Slot slot_;
  const Role role_;
  ListenerContext& context_;
  ConnectionRecord record_;
  protocols::DelayedReplies<std::string> delayed_;
  boost::asio::steady_timer write_timer_;
  std::array<std::uint8_t, 8 * kMaxMessageSize> input_{};
  std::size_t size_ = 0, used_ = 0;  // of input_
  std::deque<std::string> queue_;    // the first one is being written
  std::size_t queued_bytes_ = 0;
  std::string refusal_;
  std::string finish_why_;
  bool judged_ = false;  // whether a browser speaks
  bool reading_ = false, writing_ = false, scheduled_ = false;
  bool ended_ = false;  // the peer sends no more
  bool finishing_ = false, closed_ = false;
};

}  // namespace aprsim::simple_message
