#include "protocols/simple_message/connection.hpp"

#include <algorithm>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>

#include "protocols/net/foreign_protocol.hpp"
#include "protocols/net/peer_end.hpp"
#include "protocols/ports/wire_faults.hpp"

namespace aprsim::simple_message {
namespace {

using boost::system::error_code;

/// Requests of one connection that are processed before the other connections have their turn.
constexpr int kRequestsPerTurn = 16;
/// Replies that may wait before no more requests are taken.
constexpr std::size_t kMaxQueuedBytes = std::size_t{64} * 1024;
/// States that may wait for the reader: both of one period.
constexpr std::size_t kMaxQueuedStateBytes = 256;
/// States that may wait behind an injected delay.
constexpr std::size_t kMaxDelayedBytes = std::size_t{512} * 1024;
/// Kernel buffers: states in them are stale for a slow reader.
constexpr int kStateBufferBytes = 8 * 1024, kReplyBufferBytes = 64 * 1024;
/// Bytes that tell a browser's request from a length.
constexpr std::size_t kJudgedBytes = 4;
/// A request of a pacer that cannot be taken yet is offered again after this time of the cell;
/// while the cell is paused, after the other one of the wall.
constexpr std::chrono::milliseconds kOfferPeriod{1}, kPausedPeriod{10};

/// The length states one word too many.
void falsify_length(std::string& message, ByteOrder order) {
  constexpr std::int32_t kSurplus = 4;
  std::array<std::uint8_t, 4> word{};
  std::copy_n(message.begin(), word.size(), word.begin());
  const std::int32_t length = decode_word(word, order) + kSurplus;
  message.replace(0, word.size(), encode_word(length, order));
}

}  // namespace

Connection::Connection(boost::asio::ip::tcp::socket socket, std::string listener, std::string peer,
                       protocols::ConnectionLimiter::Slot slot, Role role, ListenerContext& context)
    : socket_(std::move(socket)),
      peer_(std::move(peer)),
      slot_(std::move(slot)),
      role_(role),
      context_(context),
      record_(context, std::move(listener), peer_),
      delayed_(
          context.io.get_executor(),
          {[this](std::string message) { enqueue(std::move(message)); }, [this] { process(); }}),
      write_timer_(context.io),
      pause_timer_(context.io),
      pacer_(context.options.listener.virtual_time, context.io.get_executor()) {
  const bool state = role == Role::kState;
  error_code ignored;
  socket_.set_option(
      boost::asio::socket_base::send_buffer_size(state ? kStateBufferBytes : kReplyBufferBytes),
      ignored);
  // A reader of states sends no requests; one that does not read is dropped anyway.
  if (state) slot_.keep();
}

void Connection::start() {
  if (!refusal_.empty()) return close(refusal_, false);
  context_.log.info(peer_ + " connected");
  read();
}

void Connection::finish(std::string_view why) {
  if (finishing_ || closed_) return;
  finishing_ = true;
  finish_why_ = why;
  static_cast<void>(close_if_finished());
}

void Connection::close(std::string_view why, bool fault) {
  if (closed_) return;
  closed_ = true;
  pacer_.leave();
  const std::string line = peer_ + (fault ? " dropped: " : " closed: ") + std::string(why);
  if (fault) {
    ++context_.counters.dropped;
    context_.log.warn(line);
  } else {
    context_.log.info(line);
  }
  error_code ignored;
  write_timer_.cancel(ignored);
  pause_timer_.cancel(ignored);
  socket_.shutdown(boost::asio::ip::tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  delayed_.close();
  record_.closed(why);
  context_.owner.ended(*this);
}

Port Connection::framing() const {
  if (context_.options.controller == ControllerKind::kMotomanFs100) return Port::kMotoman;
  return role_ == Role::kGripper ? Port::kFanucGripper : Port::kFanucMotion;
}

void Connection::read() {
  if (reading_ || ended_ || closed_ || finishing_ || size_ == input_.size()) return;
  reading_ = true;
  socket_.async_read_some(boost::asio::buffer(input_.data() + size_, input_.size() - size_),
                          [self = shared_from_this()](const error_code& error, std::size_t size) {
                            self->reading_ = false;
                            if (self->closed_) return;
                            if (!error) return self->on_read(size);
                            if (error != boost::asio::error::eof) {
                              return self->close(error.message(), false);
                            }
                            self->ended_ = true;
                            self->pacer_.finish();
                            self->process();
                          });
}

void Connection::on_read(std::size_t size) {
  if (role_ == Role::kState) return read();  // nothing is expected from its readers
  size_ += size;
  if (!judged_ && size_ >= kJudgedBytes) {
    judged_ = true;
    const std::string_view first(reinterpret_cast<const char*>(input_.data()), size_);
    // A message begins with the high bytes of a small length.
    const std::string_view protocol =
        first[0] == '\0' ? std::string_view() : protocols::foreign_protocol(first);
    if (!protocol.empty()) {
      return close("it speaks " + std::string(protocol) + ", not Simple Message", true);
    }
  }
  if (pacer_.is_registered(record_.listener())) return process_in_turn();
  process();
}

/// A pacer's request passes time, so the bytes that its client has sent before to the robot's other
/// ports come first: they are read within one turn of the event loop, and handled within the next.
void Connection::process_in_turn() {
  boost::asio::post(context_.io, [self = shared_from_this()] {
    boost::asio::post(self->context_.io, [self] { self->process(); });
  });
}

void Connection::compact() {
  if (reading_ || used_ == 0) return;
  std::copy(input_.begin() + static_cast<std::ptrdiff_t>(used_),
            input_.begin() + static_cast<std::ptrdiff_t>(size_), input_.begin());
  size_ -= used_;
  used_ = 0;
}

bool Connection::may_take() const {
  return !finishing_ && !closed_ && !pacer_.waiting() && !taken_ &&
         output_bytes() < kMaxQueuedBytes;
}

void Connection::process() {
  if (closed_) return;
  const auto keep = shared_from_this();
  int processed = 0;
  while (processed < kRequestsPerTurn && may_take()) {
    const std::span<const std::uint8_t> rest(input_.data() + used_, size_ - used_);
    const Cut cut = cut_request(rest, framing(), context_.order);
    if (cut.size == 0 || !offer(rest.first(cut.size), cut.known_length)) break;
    used_ += cut.size;
    slot_.used();
    ++processed;
  }
  if (closed_ || close_if_finished()) return;
  compact();
  if (processed == kRequestsPerTurn && !scheduled_) {
    scheduled_ = true;
    boost::asio::post(context_.io, [self = shared_from_this()] {
      self->scheduled_ = false;
      self->process();
    });
  }
  read();
}

// ---- virtual time

void Connection::join_time() {
  const std::string& role = record_.listener();
  if (pacer_.joined() || !pacer_.is_registered(role)) return;
  pacer_.join({role, api::PacerKind::kClient, context_.options.listener.endpoint});
}

bool Connection::offer(std::span<const std::uint8_t> request, bool known_length) {
  join_time();
  if (!pacer_.joined()) return context_.owner.take(*this, request, known_length);
  taken_ = true;
  taken_ = context_.owner.take(*this, request, known_length);
  if (closed_) return taken_;
  ask_for_time(taken_ ? pacer_.poll_period() +
                            protocols::injected_delay(*context_.source.latest(),
                                                      faults::Kind::kSimpleMessageDelay,
                                                      context_.options.robot)
                      : SimTime(kOfferPeriod));
  return taken_;
}

void Connection::ask_for_time(SimTime span) {
  asked_step_ = context_.source.latest()->step;
  pacer_.after(span, [weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->on_time();
  });
}

void Connection::on_time() {
  if (closed_) return;
  context_.owner.time_passed();
  if (closed_) return;
  const bool waits = !taken_ || context_.owner.owes(*this);
  if (!waits || context_.source.latest()->step != asked_step_) return go_on();
  // A paused cell grants time that does not pass.
  pause_timer_.expires_after(kPausedPeriod);
  pause_timer_.async_wait([weak = weak_from_this()](const error_code& cancelled) {
    const auto self = weak.lock();
    if (!cancelled && self && !self->closed_ && !self->pacer_.waiting()) self->go_on();
  });
}

/// After the time that was asked for: offers the request again, waits for its reply, or sends that.
void Connection::go_on() {
  if (taken_ && context_.owner.owes(*this)) return ask_for_time(SimTime(kOfferPeriod));
  taken_ = false;
  for (std::string& message : std::exchange(held_, {})) send(std::move(message), true);
  process();
}

bool Connection::close_if_finished() {
  if (!queue_.empty() || !delayed_.empty() || pacer_.waiting() || !held_.empty()) return false;
  if (finishing_) {
    close(finish_why_, false);
  } else if (ended_ && !scheduled_ && !context_.owner.owes(*this)) {
    close("by the client", false);
  }
  return closed_;
}

void Connection::notice_end() {
  if (closed_ || reading_) return;
  const auto end = protocols::notice_peer_end(socket_.native_handle());
  if (end) close("by the client", false);
}

void Connection::record_request(std::span<const std::uint8_t> request, std::string_view fault) {
  record_.request({reinterpret_cast<const char*>(request.data()), request.size()}, fault);
}

void Connection::send_state(std::string message) {
  if (closed_ || finishing_) return;
  if (queued_bytes_ > kMaxQueuedStateBytes || delayed_.bytes() > kMaxDelayedBytes) {
    ++context_.counters.skipped;
    return;
  }
  send(std::move(message), false);
}

void Connection::reply(std::string message) {
  if (pacer_.joined() && taken_) {
    held_.push_back(std::move(message));
  } else {
    send(std::move(message), true);
  }
}

void Connection::send(std::string message, bool reply) {
  if (closed_) return;
  const api::SnapshotPtr now = context_.source.latest();
  const int robot = context_.options.robot;
  const bool state = role_ == Role::kState;
  if (state && protocols::injected(*now, faults::Kind::kSimpleMessageSilent, robot)) return;
  const bool framed = framing() != Port::kFanucGripper || state;
  if (framed && protocols::injected(*now, faults::Kind::kSimpleMessageLength, robot)) {
    falsify_length(message, context_.order);
  }
  record_.sent(message, reply);
  // A client that paces has waited for it in the cell's time.
  const auto delay =
      pacer_.joined() ? std::chrono::nanoseconds(0)
                      : protocols::injected_delay(*now, faults::Kind::kSimpleMessageDelay, robot);
  if (!delayed_.must_wait(delay)) return enqueue(std::move(message));
  const std::size_t size = message.size();
  delayed_.add(std::move(message), size, delay, shared_from_this());
}

void Connection::enqueue(std::string message) {
  queued_bytes_ += message.size();
  queue_.push_back(std::move(message));
  if (!writing_) write();
}

void Connection::write() {
  if (closed_ || queue_.empty()) return;
  writing_ = true;
  write_timer_.expires_after(context_.options.write_timeout);
  write_timer_.async_wait([self = weak_from_this()](const error_code& cancelled) {
    const auto connection = self.lock();
    if (!cancelled && connection) connection->close("it did not take messages in time", true);
  });
  const std::string& message = queue_.front();
  boost::asio::async_write(socket_, boost::asio::buffer(message),
                           [self = shared_from_this()](const error_code& error, std::size_t) {
                             self->on_written(error);
                           });
}

void Connection::on_written(const error_code& error) {
  writing_ = false;
  if (closed_) return;
  if (error) return close(error.message(), false);
  error_code ignored;
  write_timer_.cancel(ignored);
  queued_bytes_ -= queue_.front().size();
  queue_.pop_front();
  write();
  if (!queue_.empty()) return;
  context_.owner.written(*this);
  process();
}

}  // namespace aprsim::simple_message
