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
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/net/connection_limiter.hpp"
#include "protocols/net/delayed_replies.hpp"
#include "protocols/net/time_pacer.hpp"
#include "protocols/simple_message/connection_record.hpp"
#include "protocols/simple_message/listener_context.hpp"

namespace aprsim::simple_message {

/// One client of one port: cuts its bytes into requests and sends whole messages, each in one
/// write. Memory is bounded, nothing waits for the peer, and a peer that takes nothing is dropped.
/// In virtual time a request of a declared pacer takes effect at once, and its reply comes after a
/// poll period of the cell's time. Thread: the listener's.
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

  /// Sends a reply, subject to injected faults; that of a pacer once its time has passed.
  void reply(std::string message);
  /// Sends a state, unless the reader has not taken the one before.
  void send_state(std::string message);
  /// Offers requests to the owner until it takes no more.
  void process();
  /// Whether bytes wait for process().
  [[nodiscard]] bool has_bytes() const { return used_ < size_; }
  /// Notices the end of a peer that nothing is read from.
  void notice_end();
  /// Whether messages are on their way to the system.
  [[nodiscard]] bool busy() const { return writing_ && !closed_; }
  /// Whether its requests are the clock of virtual time.
  [[nodiscard]] bool paces() const { return pacer_.joined(); }
  /// Counts and records a request that is taken; `fault`: why it is not understood.
  void record_request(std::span<const std::uint8_t> request, std::string_view fault = {});

 private:
  [[nodiscard]] Port framing() const;
  void read();
  void on_read(std::size_t size);
  void compact();
  [[nodiscard]] bool may_take() const;
  void process_in_turn();
  void send(std::string message, bool reply);
  void enqueue(std::string message);
  void write();
  void on_written(const boost::system::error_code& error);
  [[nodiscard]] std::size_t output_bytes() const { return queued_bytes_ + delayed_.bytes(); }
  [[nodiscard]] bool close_if_finished();
  [[nodiscard]] bool offer(std::span<const std::uint8_t> request, bool known_length);
  void join_time();
  void ask_for_time(SimTime span);
  void on_time();
  void go_on();

  boost::asio::ip::tcp::socket socket_;
  const std::string peer_;
  protocols::ConnectionLimiter::Slot slot_;
  const Role role_;
  ListenerContext& context_;
  ConnectionRecord record_;
  protocols::DelayedReplies<std::string> delayed_;
  boost::asio::steady_timer write_timer_, pause_timer_;
  protocols::TimePacer pacer_;     // no request is taken while it waits
  std::vector<std::string> held_;  // replies of a pacer until its time has passed
  std::uint64_t asked_step_ = 0;   // of the cell, when the pacer asked for time
  std::array<std::uint8_t, 8 * kMaxMessageSize> input_{};
  std::size_t size_ = 0, used_ = 0;  // of input_
  std::deque<std::string> queue_;    // the first one is being written
  std::size_t queued_bytes_ = 0;
  std::string refusal_;
  std::string finish_why_;
  bool judged_ = false;  // whether a browser speaks
  bool reading_ = false, writing_ = false, scheduled_ = false;
  bool ended_ = false;  // the peer sends no more
  bool taken_ = false;  // a pacer's request, whose time has not passed
  bool finishing_ = false, closed_ = false;
};

}  // namespace aprsim::simple_message
