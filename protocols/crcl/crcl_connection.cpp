#include "protocols/crcl/crcl_connection.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <optional>
#include <sys/socket.h>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>

#include "protocols/net/foreign_protocol.hpp"
#include "protocols/net/peer_end.hpp"

namespace aprsim::crcl_server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr int kSendBufferBytes = 64 * 1024;
// Documents of a pipelining peer that are processed before the other clients have their turn.
constexpr int kDocumentsPerTurn = 16;

}  // namespace

CrclConnection::CrclConnection(asio::ip::tcp::socket socket, std::string peer,
                               protocols::ConnectionLimiter::Slot slot,
                               protocols::ConnectionTrace trace, const CrclServerOptions& options,
                               CommandExecutor& executor, CrclCounters& counters, Events events)
    : socket_(std::move(socket)),
      slot_(std::move(slot)),
      trace_(std::move(trace)),
      options_(options),
      executor_(executor),
      counters_(counters),
      events_(std::move(events)),
      session_(options, executor, counters, socket_.get_executor(), std::move(peer),
               options.listener.virtual_time, events_.time, *this),
      framer_(crcl::Framer::for_commands(options.max_message_bytes, options.max_program_bytes)),
      write_timer_(socket_.get_executor()),
      idle_timer_(socket_.get_executor()),
      document_timer_(socket_.get_executor()) {}

void CrclConnection::start() {
  error_code ignored;
  socket_.non_blocking(true, ignored);
  socket_.set_option(boost::asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
  executor_.log().info(peer() + " connected");
  read();
}

void CrclConnection::drain() {
  if (closed_) return;
  draining_ = true;
  if (all_sent()) close();
}

void CrclConnection::close() {
  if (closed_) return;
  closed_ = true;
  session_.close();
  error_code ignored;
  write_timer_.cancel(ignored);
  idle_timer_.cancel(ignored);
  document_timer_.cancel(ignored);
  socket_.shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  executor_.client_gone(session_.caller());
  trace_.closed(end_);
  events_.end(*this);
}

void CrclConnection::drop(const std::string& reason) {
  if (closed_) return;
  ++counters_.dropped;
  executor_.log().warn("closing " + peer() + ": " + reason);
  end_ = reason;
  close();
}

void CrclConnection::drop_unfinished() {
  drop("its unfinished document of " + std::to_string(framer_.buffered()) +
       " bytes is the largest, and all together exceed " +
       std::to_string(options_.max_unfinished_bytes) + " bytes");
}

void CrclConnection::exclude() {
  session_.exclude();
  break_off();
}

void CrclConnection::watch(asio::steady_timer& timer, std::chrono::milliseconds limit,
                           std::string reason) {
  if (limit.count() <= 0) return;
  timer.expires_after(limit);
  timer.async_wait([self = weak_from_this(), reason = std::move(reason)](const error_code& error) {
    const auto connection = self.lock();
    if (!error && connection) connection->drop(reason);
  });
}

void CrclConnection::read() {
  acknowledge_at_once();
  watch(idle_timer_, options_.idle_timeout, "idle for too long");
  socket_.async_read_some(asio::buffer(input_),
                          [self = shared_from_this()](const error_code& error, std::size_t size) {
                            self->on_read(error, size);
                          });
}

void CrclConnection::on_read(const error_code& error, std::size_t size) {
  if (closed_) return;
  if (error && error != asio::error::eof) return end_with(error);
  if (error) {
    executor_.log().info(peer() + " disconnected");
    end_ = "by the client";
    // A peer that has only finished sending may still wait for its statuses.
    return drain();
  }
  if (draining_) return;
  read_at_ = std::chrono::steady_clock::now();
  error_code ignored;
  idle_timer_.cancel(ignored);
  const std::string_view bytes(input_.data(), size);
  // Bytes of a web page are no command, and no error of the robot.
  if (!heard_) {
    const std::string_view protocol = protocols::foreign_protocol(bytes);
    if (!protocol.empty()) return drop("it speaks " + std::string(protocol) + ", not CRCL");
    heard_ = true;
  }
  framer_.append(bytes);
  process();
  if (!closed_ && framer_.buffered() > input_.size()) events_.input();
}

// Existing clients leave Nagle's algorithm on and follow a command, which has no answer, with a
// GetStatus. That would wait some 40 ms for the delayed acknowledgement of the command. The option
// is temporary, so it is set before each read.
void CrclConnection::acknowledge_at_once() {
  const int on = 1;
  (void)::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_QUICKACK, &on, sizeof on);
}

// Processes buffered documents, a few at a time, and reads when there are none. on_room() resumes
// it when the peer has taken statuses; on_taken() does when the session has processed a delayed
// document.
void CrclConnection::process() {
  if (closed_ || draining_ || !follow_peer()) return;
  for (int i = 0; i < kDocumentsPerTurn; ++i) {
    full_ = !has_room();
    if (closed_ || draining_ || full_ || session_.busy()) return;
    crcl::Result<std::optional<std::string>> document = framer_.next();
    if (!document) return session_.fail(document.error());
    watch_document(!*document && framer_.buffered() > 0);
    if (!*document) return read();
    slot_.used();
    trace_.received_first(**document);
    if (framer_.last_root() == 0) {
      session_.take(CommandDocument{*std::move(*document)}, read_at_);
    } else {
      session_.take(ProgramDocument{*std::move(*document)}, read_at_);
    }
    trace_.catch_up();
  }
  asio::post(socket_.get_executor(), [self = shared_from_this()] { self->process(); });
}

// Follows the peer's end as soon as the system knows of it: bytes before it may be unread. A closed
// peer still gets its statuses, and what it sent last is executed: a turn of commands, or none if
// reading pauses. False: the connection has ended.
bool CrclConnection::follow_peer() {
  const auto noticed = protocols::notice_peer_end(socket_.native_handle());
  if (noticed && noticed->error != asio::error::eof) {
    end_with(noticed->error);
    return false;
  }
  if (noticed) {
    const bool first = !std::exchange(peer_closed_, true);
    if (is_paused()) {
      last_commands_ = 0;
    } else if (first) {
      last_commands_ = kDocumentsPerTurn;
    }
  }
  return true;
}

void CrclConnection::notice_end() {
  if (!closed_ && !draining_ && is_paused()) (void)follow_peer();
}

bool CrclConnection::admits_command() {
  if (!peer_closed_) return true;
  if (last_commands_ > 0) {
    --last_commands_;
    return true;
  }
  executor_.log().warn(peer() + " has closed: its unread commands are dropped");
  end_ = "by the client";
  drain();
  return false;
}

// A controller that was killed or cut off leaves its robot without supervision, so the robot stops,
// as by NIST's servers.
void CrclConnection::end_with(const error_code& error) {
  if (closed_) return;
  executor_.log().info(peer() + " disconnected (" + error.message() + ")");
  end_ = "by the client";
  const bool lost = protocols::peer_end(error) == protocols::PeerEnd::kLost;
  if (lost) executor_.client_lost(session_.caller(), error.message());
  close();
}

// The deadline is that of the whole document, however slowly its bytes arrive.
void CrclConnection::watch_document(bool incomplete) {
  if (incomplete == incomplete_) return;
  incomplete_ = incomplete;
  error_code ignored;
  if (incomplete) {
    watch(document_timer_, options_.document_timeout, "a document was not complete in time");
  } else {
    document_timer_.cancel(ignored);
  }
}

void CrclConnection::refuse(const std::string& reason) {
  end_ = reason;
  drain();
}

// Nothing is read meanwhile, but time must not wait for a client that is gone.
void CrclConnection::watch_end() {
  if (std::exchange(watches_end_, true)) return;
  socket_.async_wait(
      asio::ip::tcp::socket::wait_read, [self = shared_from_this()](const error_code& failed) {
        self->watches_end_ = false;
        if (failed || self->closed_ || !self->session_.waits_for_time()) return;
        char byte = 0;
        error_code error;
        self->socket_.receive(asio::buffer(&byte, 1), asio::socket_base::message_peek, error);
        if (error == asio::error::would_block) return self->watch_end();
        if (error) self->session_.finish_time();
      });
}

void CrclConnection::send(Answer answer) {
  output_ += answer.document;
  // Sent before it is traced.
  if (!blocked_) flush();
  trace_.sent(answer.document);
}

void CrclConnection::send_half(Answer answer) {
  answer.document.resize(answer.document.size() / 2);
  send(std::move(answer));
  end_ = "an injected fault";
  drain();
}

// Also when statuses that were held back are out.
void CrclConnection::on_room() {
  if (closed_) return;
  if (draining_ && all_sent()) return close();
  if (full_ && has_room()) process();
}

// Sends as much as the peer takes, nearly always everything, and waits with the rest.
void CrclConnection::flush() {
  error_code error;
  const std::size_t sent = socket_.write_some(asio::buffer(output_), error);
  output_.erase(0, sent);
  if (error && error != asio::error::would_block) return end_with(error);
  if (output_.empty()) return;
  blocked_ = true;
  watch(write_timer_, options_.write_timeout, "it did not take its pending statuses in time");
  socket_.async_wait(
      asio::ip::tcp::socket::wait_write,
      [self = shared_from_this()](const error_code& failed) { self->on_writable(failed); });
}

void CrclConnection::on_writable(const error_code& error) {
  if (closed_) return;
  if (error) return end_with(error);
  error_code ignored;
  write_timer_.cancel(ignored);
  blocked_ = false;
  flush();
  on_room();
}

}  // namespace aprsim::crcl_server
