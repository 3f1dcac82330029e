#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include "crcl/framer.hpp"
#include "protocols/crcl/crcl_session.hpp"
#include "protocols/net/connection_limiter.hpp"
#include "protocols/record/connection_trace.hpp"

namespace aprsim::crcl_server {

/// One client's socket: frames its bytes and carries the documents of its session.
/// Reading pauses while the peer does not take its statuses, so that the memory for it is
/// bounded. Keeps itself alive while an operation is pending. Thread: the server's.
class CrclConnection final : public SessionWire,
                             public std::enable_shared_from_this<CrclConnection> {
 public:
  using OnEnd = std::function<void(CrclConnection&)>;
  /// Notifications of the server. `input`: more than a read buffer is unfinished; the connection
  /// may be closed meanwhile. `end`: once, when the socket has been closed. `time` as in
  /// CrclSession.
  struct Events {
    std::function<void()> time, input;
    OnEnd end;
  };

  CrclConnection(boost::asio::ip::tcp::socket socket, std::string peer,
                 protocols::ConnectionLimiter::Slot slot, protocols::ConnectionTrace trace,
                 const CrclServerOptions& options, CommandExecutor& executor,
                 CrclCounters& counters, Events events);

  void start();
  /// Accepts no further commands; closes once pending statuses are sent.
  void drain();
  /// Closes at once.
  void close();
  void evict() { drop("evicted for a new client"); }
  /// Closes as if the wire were cut.
  void break_off() { drop("an injected fault"); }
  /// The same, and the client may not pace virtual time again for a while.
  void exclude();
  /// Checks whether the peer has closed or was lost while nothing is read from it. To be called
  /// every few milliseconds.
  void notice_end();

  [[nodiscard]] protocols::ConnectionLimiter::Slot& slot() { return slot_; }
  /// Bytes that have come and are not processed.
  [[nodiscard]] std::size_t unfinished_bytes() const { return framer_.buffered(); }
  /// Closes it in favour of other connections' documents.
  void drop_unfinished();
  [[nodiscard]] const std::string& peer() const { return session_.caller().peer; }
  /// Whether its polls pass virtual time.
  [[nodiscard]] bool paces() const { return session_.paces(); }

 private:
  // The wire, as the session sees it.
  [[nodiscard]] std::shared_ptr<SessionWire> hold() override { return shared_from_this(); }
  [[nodiscard]] bool carries_documents() const override { return true; }
  [[nodiscard]] bool closed() const override { return closed_; }
  [[nodiscard]] bool ended() const override { return closed_ || draining_; }
  [[nodiscard]] bool admits_command() override;
  void send(Answer answer) override;
  void send_half(Answer answer) override;
  void on_room() override;
  void on_taken() override { process(); }
  void watch_end() override;
  void refuse(const std::string& reason) override;
  void drop(const std::string& reason) override;

  void read();
  void on_read(const boost::system::error_code& error, std::size_t size);
  void acknowledge_at_once();
  void process();
  [[nodiscard]] bool is_paused() const { return full_ || session_.busy(); }
  [[nodiscard]] bool follow_peer();
  void end_with(const boost::system::error_code& error);
  void watch_document(bool incomplete);
  /// Nothing is left to send.
  [[nodiscard]] bool all_sent() const { return output_.empty() && session_.all_sent(); }
  [[nodiscard]] bool has_room() const {
    return output_.size() + session_.held_bytes() < options_.max_output_bytes;
  }
  void flush();
  void on_writable(const boost::system::error_code& error);
  void watch(boost::asio::steady_timer& timer, std::chrono::milliseconds limit, std::string reason);

  boost::asio::ip::tcp::socket socket_;
  protocols::ConnectionLimiter::Slot slot_;
  protocols::ConnectionTrace trace_;
  std::string end_;  // why it ends
  const CrclServerOptions& options_;
  CommandExecutor& executor_;
  CrclCounters& counters_;
  const Events events_;

  CrclSession session_;
  crcl::Framer framer_;
  bool heard_ = false;  // anything yet
  std::array<char, 8192> input_{};
  std::string output_;        // statuses, or the rest of one, that the peer has not read yet
  bool watches_end_ = false;  // of the peer's input, while the session waits for virtual time
  boost::asio::steady_timer write_timer_, idle_timer_, document_timer_;
  bool incomplete_ = false;  // the beginning of a document waits for its rest
  std::chrono::steady_clock::time_point read_at_{};  // the latest bytes
  bool blocked_ = false;                             // waiting for the peer to take more
  bool full_ = false;                                // no document is processed until then
  bool draining_ = false;                            // no input is accepted any more
  bool peer_closed_ = false;                         // it has closed; unread bytes may be left
  int last_commands_ = 0;                            // commands still taken from it then
  bool closed_ = false;
};

}  // namespace aprsim::crcl_server
