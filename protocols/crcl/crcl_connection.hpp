#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "crcl/error.hpp"
#include "crcl/framer.hpp"
#include "protocols/connection_places.hpp"
#include "protocols/crcl/command_executor.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/crcl_server.hpp"
#include "protocols/wire_trace.hpp"
#include "world/api/duration_histogram.hpp"

namespace aprsim::crcl_server {

/// Counters of a server's connections together, for any thread to read.
struct CrclCounters {
  std::atomic<std::uint64_t> dropped{0}, commands{0}, statuses{0};
  api::DurationHistogram answer_times;  ///< from the read that completes a GetStatus
};

/// One client's socket: frames its bytes, passes commands to the robot's executor, answers
/// GetStatus.
/// While the peer does not take its statuses nothing more is read from it, so that what is kept
/// for it is bounded. Keeps itself alive while an operation is pending. Thread: the server's.
class CrclConnection : public std::enable_shared_from_this<CrclConnection> {
 public:
  using OnEnd = std::function<void(CrclConnection&)>;

  /// `on_time` is called when virtual time has come as far as was asked for, and may end the
  /// connection; `on_end` is called once, when the socket has been closed.
  CrclConnection(boost::asio::ip::tcp::socket socket, std::string peer,
                 protocols::ConnectionPlaces::Place place, protocols::ConnectionTrace trace,
                 const CrclServerOptions& options, CommandExecutor& executor,
                 CrclCounters& counters, std::function<void()> on_time, OnEnd on_end);

  void start();
  /// Takes no further commands, closes once pending statuses are out.
  void drain();
  /// Closes at once.
  void close();
  void give_way() { drop("its place is needed"); }
  /// As if the wire were cut.
  void break_off() { drop("an injected fault"); }
  /// The same, and it is not let in again for a while.
  void shut_out();

  [[nodiscard]] protocols::ConnectionPlaces::Place& place() { return place_; }
  [[nodiscard]] const std::string& peer() const { return caller_.peer; }
  /// Whether its polls pass virtual time.
  [[nodiscard]] bool paces() const { return pacer_.has_value(); }

 private:
  void read();
  void on_read(const boost::system::error_code& error, std::size_t size);
  void acknowledge_at_once();
  void process();
  void handle(const std::string& document);
  void handle_command(const std::string& document);
  void handle_program(const std::string& document);
  void handle_undecodable(const crcl::Error& error);
  void fail_document(const crcl::Error& error);
  void poll();
  void answer_status();
  void join_time(bool polls);
  void after(SimTime span, std::function<void()> then);
  void on_reached();
  void watch_end();
  void take(const std::string& document);
  void pause(std::string document, std::chrono::nanoseconds time);
  void send_later(std::string document, std::chrono::nanoseconds time);
  void send_due();
  /// Nothing is left to send.
  [[nodiscard]] bool all_sent() const { return output_.empty() && late_.empty(); }
  [[nodiscard]] bool polls_tapped() const { return options_.tap && options_.tap->wants_polls(); }
  void tap_command(std::string type, std::int64_t id, std::string fault,
                   const std::string& document);
  void tap_error(const crcl::Error& error, const std::string& document);
  void tap_status(const crcl::CommandStatus& status, const std::string& document);
  void watch_document(bool incomplete);
  void flush();
  void on_writable(const boost::system::error_code& error);
  void drop(const std::string& reason);
  void watch(boost::asio::steady_timer& timer, std::chrono::milliseconds limit, std::string reason);

  boost::asio::ip::tcp::socket socket_;
  protocols::ConnectionPlaces::Place place_;
  protocols::ConnectionTrace trace_;
  std::string end_;  // why it ends
  const CrclServerOptions& options_;
  CommandExecutor& executor_;
  CrclCounters& counters_;
  std::function<void()> on_time_;
  OnEnd on_end_;

  Caller caller_;
  crcl::Framer framer_;
  bool heard_ = false;  // anything yet
  std::array<char, 8192> input_{};
  std::string get_status_;  // the latest GetStatus, which clients repeat byte for byte
  std::string output_;      // statuses, or the rest of one, that the peer has not read yet
  struct Late {
    std::chrono::steady_clock::time_point due;
    std::string document;
  };
  std::deque<Late> late_;              // statuses that an injected fault holds back
  std::size_t late_bytes_ = 0;         // of them
  bool paused_ = false;                // an injected fault holds back the document at hand
  std::optional<api::PacerId> pacer_;  // in virtual time
  std::function<void()> then_;         // once that has come as far as was asked for; empty = now
  bool watches_end_ = false;           // of what the peer sends, while that lasts
  boost::asio::steady_timer write_timer_, idle_timer_, document_timer_, late_timer_, pause_timer_;
  bool incomplete_ = false;  // the beginning of a document waits for its rest
  std::chrono::steady_clock::time_point read_at_{},  // the latest bytes
      received_{};         // of the document at hand, while polls are tapped
  bool blocked_ = false;   // waiting for the peer to take more
  bool full_ = false;      // nothing more is handled until then
  bool draining_ = false;  // nothing more is taken from the peer
  bool closed_ = false;
};

}  // namespace aprsim::crcl_server
