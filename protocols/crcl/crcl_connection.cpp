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

namespace aprsim::crcl_server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr int kSendBufferBytes = 64 * 1024;
// A peer that pipelines gets no more than this before the others have their turn.
constexpr int kDocumentsPerTurn = 16;

}  // namespace

CrclConnection::CrclConnection(asio::ip::tcp::socket socket, std::string peer,
                               protocols::ConnectionLimiter::Slot slot,
                               protocols::ConnectionTrace trace, const CrclServerOptions& options,
                               CommandExecutor& executor, CrclCounters& counters,
                               std::function<void()> on_time, OnEnd on_end)
    : socket_(std::move(socket)),
      slot_(std::move(slot)),
      trace_(std::move(trace)),
      options_(options),
      executor_(executor),
      counters_(counters),
      on_end_(std::move(on_end)),
      session_(options, executor, counters, socket_.get_executor(), std::move(peer),
               options.listener.virtual_time, std::move(on_time), *this),
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
  on_end_(*this);
}

void CrclConnection::drop(const std::string& reason) {
  if (closed_) return;
  ++counters_.dropped;
  executor_.log().warn("closing " + peer() + ": " + reason);
  end_ = reason;
  close();
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
  if (error) {
    executor_.log().info(peer() + " disconnected" +
                         (error == asio::error::eof ? "" : " (" + error.message() + ")"));
    end_ = "by the client";
    // A peer that has only finished sending may still wait for its statuses.
    return error == asio::error::eof ? drain() : close();
  }
  if (draining_) return;
  read_at_ = std::chrono::steady_clock::now();
  error_code ignored;
  idle_timer_.cancel(ignored);
  const std::string_view bytes(input_.data(), size);
  // Bytes of a web page are nobody's command, and no error of the robot's.
  if (!heard_) {
    const std::string_view protocol = protocols::foreign_protocol(bytes);
    if (!protocol.empty()) return drop("it speaks " + std::string(protocol) + ", not CRCL");
    heard_ = true;
  }
  framer_.append(bytes);
  process();
}

// Existing clients leave Nagle's algorithm on and follow a command, which has no answer, with a
// GetStatus: that would wait some 40 ms for the delayed acknowledgement of the command. The option
// lasts only for a while, so it is set whenever all that came has been handled.
void CrclConnection::acknowledge_at_once() {
  const int on = 1;
  (void)::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_QUICKACK, &on, sizeof on);
}

// Goes on with the documents at hand, a few at a time; reads on when there are none. While the peer
// has too many statuses to take, on_room() comes back here; while the session holds something back,
// that does.
void CrclConnection::process() {
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

// However the rest drips in, it has to be there in time.
void CrclConnection::watch_document(bool incomplete) {
  if (incomplete == incomplete_) return;
  incomplete_ = incomplete;
  error_code ignored;
  if (incomplete) {
    watch(document_timer_, options_.document_timeout, "a document stayed incomplete");
  } else {
    document_timer_.cancel(ignored);
  }
}

void CrclConnection::refuse(const std::string& reason) {
  end_ = reason;
  drain();
}

// Nothing is read meanwhile, but a client that is gone shall not have others left behind.
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
  // On its way before it is traced.
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

// Sends at once what the peer takes, which is nearly always all, and waits with the rest.
void CrclConnection::flush() {
  error_code error;
  const std::size_t sent = socket_.write_some(asio::buffer(output_), error);
  output_.erase(0, sent);
  if (error && error != asio::error::would_block) return close();
  if (output_.empty()) return;
  blocked_ = true;
  watch(write_timer_, options_.write_timeout, "takes none of its pending statuses");
  socket_.async_wait(
      asio::ip::tcp::socket::wait_write,
      [self = shared_from_this()](const error_code& failed) { self->on_writable(failed); });
}

void CrclConnection::on_writable(const error_code& error) {
  if (closed_) return;
  if (error) return close();
  error_code ignored;
  write_timer_.cancel(ignored);
  blocked_ = false;
  flush();
  on_room();
}

}  // namespace aprsim::crcl_server
