#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>

#include "crcl/documents.hpp"
#include "crcl/error.hpp"
#include "protocols/crcl/command_executor.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/crcl_server.hpp"
#include "protocols/net/delayed_replies.hpp"
#include "protocols/net/time_pacer.hpp"
#include "world/base/duration_histogram.hpp"

namespace aprsim::crcl_server {

/// Counters of a server's sessions together, for any thread to read.
struct CrclCounters {
  std::atomic<std::uint64_t> dropped{0}, commands{0}, statuses{0};
  api::DurationHistogram answer_times;  ///< from the read that completes a GetStatus
};

/// Input of a client: a document as it stands, or the result of reading a message.
struct CommandDocument {
  std::string text;
};
struct ProgramDocument {
  std::string text;
};
using Received = std::variant<CommandDocument, ProgramDocument, crcl::Result<crcl::CommandInstance>,
                              crcl::Result<crcl::Program>>;

/// A status on its way to a client; as a document too, where the wire carries documents.
struct Answer {
  crcl::Status status;
  std::string document;
};

/// The wire that a session is carried on.
class SessionWire {
 public:
  virtual ~SessionWire() = default;
  /// Keeps the wire, and with it the session, while something of the session is pending.
  [[nodiscard]] virtual std::shared_ptr<SessionWire> hold() = 0;
  [[nodiscard]] virtual bool carries_documents() const = 0;
  [[nodiscard]] virtual bool closed() const = 0;
  /// Nothing more is taken from the client.
  [[nodiscard]] virtual bool ended() const = 0;
  /// Whether the next command is executed. A client that is gone has its unread ones dropped.
  [[nodiscard]] virtual bool admits_command() = 0;
  virtual void send(Answer answer) = 0;
  /// An injected fault: half of it, and no more.
  virtual void send_half(Answer answer) = 0;
  /// Replies that were held back have been sent.
  virtual void on_room() = 0;
  /// The document that was held back has been taken; the next may come.
  virtual void on_taken() = 0;
  /// The session waits for virtual time, and the client may vanish meanwhile.
  virtual void watch_end() = 0;
  /// Ends: the peer has sent what is no document of the language.
  virtual void refuse(const std::string& reason) = 0;
  /// Ends at once.
  virtual void drop(const std::string& reason) = 0;
};

/// One client's session with the robot: passes its commands to the robot's executor, answers each
/// GetStatus by one status, keeps to virtual time where it paces that, and does what injected
/// faults of the port ask for. Knows no sockets. A member of its wire. Thread: the server's.
class CrclSession {
 public:
  /// `virtual_time`: null = it does not pace. `on_time` is called when virtual time has come as far
  /// as was asked for, and may end the session.
  CrclSession(const CrclServerOptions& options, CommandExecutor& executor, CrclCounters& counters,
              const boost::asio::any_io_executor& io, std::string peer,
              api::VirtualTime* virtual_time, std::function<void()> on_time, SessionWire& wire);

  /// Takes what has come since `read_at`; the next only while not busy().
  void take(Received received, std::chrono::steady_clock::time_point read_at);
  /// Something is held back; the wire hears of its end by on_taken().
  [[nodiscard]] bool busy() const { return paused_ || pacer_.waiting(); }
  /// Size of statuses that wait for their time [bytes].
  [[nodiscard]] std::size_t held_bytes() const { return late_.bytes(); }
  [[nodiscard]] bool all_sent() const { return late_.empty(); }
  /// A document that could not even be cut out of the stream.
  void fail(const crcl::Error& error);

  /// The client may yet be gone: nobody is left behind for its sake.
  void finish_time() { pacer_.finish(); }
  /// Waits for virtual time.
  [[nodiscard]] bool waits_for_time() const { return pacer_.waiting(); }
  /// Whether its polls pass virtual time.
  [[nodiscard]] bool paces() const { return pacer_.joined(); }
  /// Not let in again for a while.
  void exclude() { pacer_.exclude(); }
  /// No more of anything. Again: nothing.
  void close();

  [[nodiscard]] const Caller& caller() const { return caller_; }

 private:
  void guarded(const std::function<void()>& work);
  void handle(const Received& received);
  void handle_document(const CommandDocument& document);
  void handle_document(const ProgramDocument& document);
  void handle_command(const crcl::Result<crcl::CommandInstance>& command,
                      const std::string& document);
  void handle_program(const crcl::Result<crcl::Program>& program, const std::string& document);
  void handle_undecodable(const crcl::Error& error);
  [[nodiscard]] bool admits_command();
  [[nodiscard]] bool refused_by_schema(const std::string& document);
  void poll();
  void answer_status();
  void join_time(bool polls);
  void after(SimTime span, std::function<void()> then);
  void pause(Received received, std::chrono::nanoseconds time);
  [[nodiscard]] bool polls_tapped() const { return options_.tap && options_.tap->wants_polls(); }
  void tap_command(std::string type, std::int64_t id, std::string fault,
                   const std::string& document);
  void tap_error(const crcl::Error& error, const std::string& document);
  void tap_status(const crcl::CommandStatus& status, const std::string& document);

  const CrclServerOptions& options_;
  CommandExecutor& executor_;
  CrclCounters& counters_;
  std::function<void()> on_time_;
  SessionWire& wire_;

  Caller caller_;
  std::string get_status_;  // the latest GetStatus, which clients repeat byte for byte
  protocols::DelayedReplies<Answer> late_;  // statuses that an injected fault holds back
  protocols::TimePacer pacer_;
  bool paused_ = false;  // an injected fault holds back the document at hand
  boost::asio::steady_timer pause_timer_;
  std::chrono::steady_clock::time_point read_at_{},  // the bytes of the document at hand
      received_{};                                   // itself, while polls are tapped
};

}  // namespace aprsim::crcl_server
