#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "modbus/request_validator.hpp"
#include "protocols/conveyor/conveyor_device.hpp"
#include "protocols/modbus/modbus_server.hpp"
#include "protocols/modbus/reply_builder.hpp"
#include "protocols/net/connection_places.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/record/wire_trace.hpp"
#include "world/base/duration_histogram.hpp"
#include "world/base/rate_limit.hpp"

namespace aprsim::modbus_server {

class Connection;

struct Counters {
  std::atomic<std::uint64_t> dropped{0}, requests{0}, exceptions{0};
  api::DurationHistogram answer_times;  ///< from a request to its reply
};

/// What all connections of a listener share. Thread: the listener's.
struct ListenerContext {
  boost::asio::io_context& io;
  const ModbusServerOptions& options;
  ConveyorDevice& device;
  ReplyBuilder& replies;
  protocols::LimitedLog& log;
  Counters& counters;
  modbus::RequestRules rules;
  const api::SnapshotSource& source;  ///< of injected faults
  /// Calls poll_applied() of this connection every millisecond or so until it returns false.
  std::function<void(std::shared_ptr<Connection>)> await_applied;
  std::function<void(Connection&)> closed;
};

/// One client: bytes in, each request validated, replies out in the order of the requests. Memory
/// is bounded, nothing waits for the peer, and a peer that stalls is dropped. Thread: the
/// listener's.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Clock = std::chrono::steady_clock;

  Connection(boost::asio::ip::tcp::socket socket, std::string peer,
             protocols::ConnectionPlaces::Place place, ListenerContext& context);

  void start();
  /// Answers the write under way, sends what is ready, then closes. Takes no more requests.
  void drain();
  /// Ends the connection now; `fault` when the peer is to blame.
  void close(std::string_view why, bool fault);
  void close() { close("the server stops", false); }
  void give_way() { close("its place is needed", true); }
  [[nodiscard]] protocols::ConnectionPlaces::Place& place() { return place_; }
  /// Looks whether the write under way has been applied or has run out of time. False: done.
  [[nodiscard]] bool poll_applied(Clock::time_point now);

 private:
  struct WaitingWrite {
    api::Ticket ticket = 0;
    Clock::time_point deadline;
    std::vector<std::uint8_t> adu;
  };

  void read();
  void on_read(std::size_t size);
  void on_end_of_stream(const boost::system::error_code& error);
  void process();
  [[nodiscard]] bool process_request();
  [[nodiscard]] bool close_if_finished();
  void join_time();
  /// Of a client that paces: what it writes takes effect now, and it is answered a poll period
  /// later.
  void take_time(const modbus::ValidatedRequest& validated);
  void on_reached();
  void handle(const modbus::ValidatedRequest& validated);
  void execute(const modbus::ValidatedRequest& validated);
  void answer(std::span<const std::uint8_t> adu);
  void refuse(std::span<const std::uint8_t> adu, modbus::ExceptionCode code);
  /// To the peer, as injected faults let it.
  void reply(std::span<const std::uint8_t> adu);
  void send_due();
  /// Shows one message, a whole one, to whoever watches or keeps it.
  /// A reply is as much of a poll as its request.
  void tap(bool from_client, std::span<const std::uint8_t> adu);
  /// Of whole messages, one after the other.
  void trace_sent(std::span<const std::uint8_t> adus);
  void send();
  void on_sent(const boost::system::error_code& error);
  [[nodiscard]] bool may_process_request() const;
  void set_timer();
  void on_timer();

  boost::asio::ip::tcp::socket socket_;
  const std::string peer_;
  protocols::ConnectionPlaces::Place place_;
  ListenerContext& context_;
  protocols::ConnectionTrace trace_;
  boost::asio::steady_timer timer_;
  protocols::RateLimit rate_;

  // Sixteen of the longest requests: a client that pipelines more waits in the kernel's buffer.
  std::array<std::uint8_t, 16 * modbus::kMaxAduSize> in_;
  std::size_t in_size_ = 0, in_used_ = 0;
  std::vector<std::uint8_t> out_, sending_;
  struct Late {
    Clock::time_point due;
    std::vector<std::uint8_t> adu;
  };
  std::deque<Late> late_;       // replies that an injected fault holds back
  std::size_t late_bytes_ = 0;  // of them
  boost::asio::steady_timer late_timer_;
  std::optional<WaitingWrite> waiting_;
  std::optional<api::PacerId> pacer_;    // in virtual time
  bool asked_ = false;                   // for more of it: nothing goes out before
  std::vector<std::uint8_t> to_answer_;  // the request that is answered then
  Clock::time_point received_{};         // of the request at hand
  bool heard_ = false;                   // enough to tell the protocol
  bool reading_ = false, scheduled_ = false, incomplete_ = true;
  bool ended_ = false, draining_ = false, closed_ = false;
  std::string_view broken_;  // why the stream cannot be framed; empty while it can

  static constexpr Clock::time_point kNever = Clock::time_point::max();
  Clock::time_point request_due_ = kNever, reply_due_ = kNever, idle_due_ = kNever;
  Clock::time_point timer_at_ = kNever;
};

}  // namespace aprsim::modbus_server
