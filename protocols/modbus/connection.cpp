#include "protocols/modbus/connection.hpp"

#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/write.hpp>
#include <fmt/format.h>

#include "protocols/modbus/reply_faults.hpp"
#include "protocols/net/peer_end.hpp"
#include "protocols/net/tls.hpp"
#include "protocols/ports/wire_faults.hpp"

namespace aprsim::modbus_server {
namespace {

using boost::system::error_code;
using modbus::Verdict;

// Requests of one connection that are processed before the other connections have their turn.
constexpr int kRequestsPerTurn = 16;

// Kernel buffer for a client that does not read.
constexpr int kSendBufferBytes = 64 * 1024;

}  // namespace

Connection::Connection(boost::asio::ip::tcp::socket socket, std::string peer,
                       protocols::ConnectionLimiter::Slot slot, ListenerContext& context)
    : stream_(std::move(socket),
              context.options.listener.tls ? context.options.listener.tls->context() : nullptr),
      peer_(std::move(peer)),
      slot_(std::move(slot)),
      context_(context),
      record_(context, peer_),
      deadlines_(context.io.get_executor(), context.options, [this] { on_deadline(); }),
      rate_(context.options.max_requests_per_s),
      reader_(context.rules),
      executor_(context, peer_),
      replies_(context.io.get_executor(),
               {[this](std::span<const std::uint8_t> adus) { record_.sent(adus); },
                [this] { process(); }}),
      pacer_(context.options.listener.virtual_time, context.io.get_executor()) {}

void Connection::start() {
  error_code ignored;
  stream_.next_layer().set_option(boost::asio::socket_base::send_buffer_size(kSendBufferBytes),
                                  ignored);
  deadlines_.restart_idle();
  context_.log.info(peer_ + " connected");
  ready_ = !stream_.is_secure();
  if (!ready_) {
    deadlines_.begin_handshake();
    context_.handshakes.admit(this, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->begin_handshake();
    });
  }
  deadlines_.watch(shared_from_this());
  read();
}

void Connection::begin_handshake() {
  stream_.async_handshake([self = shared_from_this()](const error_code& error) {
    if (!self->closed_) self->on_handshake(error);
  });
}

void Connection::on_handshake(const error_code& error) {
  deadlines_.end_handshake();
  if (error) {
    const auto& tls = context_.options.listener.tls;
    return close(tls->failure(stream_.native_handle(), error.message()), true);
  }
  auto rights = rights_of(stream_.native_handle(), context_.options.roles);
  if (!rights) return close(rights.error().message, true);
  rights_ = std::move(*rights);
  ready_ = true;
  record_.identify(rights_.identity());
  context_.log.info(
      fmt::format("{} is {}: {}", peer_, rights_.identity(), protocols::to_text(rights_.role())));
  process();
}

void Connection::drain() {
  draining_ = true;
  pacer_.cancel();
  if (pacer_.joined() && executor_.waiting()) context_.await_applied(shared_from_this());
  process();
}

void Connection::close(std::string_view why, bool fault) {
  if (closed_) return;
  closed_ = true;
  executor_.cancel();
  pacer_.leave();
  const std::string line = peer_ + (fault ? " dropped: " : " closed: ") + std::string(why);
  if (fault) {
    ++context_.counters.dropped;
    context_.log.warn(line);
  } else {
    context_.log.info(line);
  }
  if (!ready_) context_.handshakes.leave(this);
  // Begins to send close_notify, without waiting for the client's.
  if (ready_ && stream_.is_secure()) {
    stream_.async_shutdown([self = shared_from_this()](const error_code&) {});
  }
  error_code ignored;
  stream_.next_layer().close(ignored);
  deadlines_.close();
  replies_.close();
  record_.closed(why);
  context_.closed(*this);
}

void Connection::read() {
  const std::span<std::uint8_t> room = reader_.room();
  if (!ready_ || reading_ || ended_ || draining_ || closed_ || room.empty()) return;
  reading_ = true;
  stream_.async_read_some(boost::asio::buffer(room.data(), room.size()),
                          [self = shared_from_this()](const error_code& error, std::size_t size) {
                            self->reading_ = false;
                            if (self->closed_) return;
                            if (error) {
                              self->on_end_of_stream(error);
                            } else {
                              self->on_read(size);
                            }
                          });
}

void Connection::on_read(std::size_t size) {
  reader_.append(size);
  const std::string_view protocol = reader_.foreign_protocol();
  if (!protocol.empty()) {
    return close("it speaks " + std::string(protocol) + ", not Modbus", true);
  }
  process();
}

void Connection::on_end_of_stream(const error_code& error) {
  // Many clients close without close_notify. A request is framed by itself, so none is cut short.
  if (error != boost::asio::error::eof && error != boost::asio::ssl::error::stream_truncated) {
    close(error.message(), false);
    return;
  }
  // The peer sends no more; its complete requests are still answered.
  ended_ = true;
  process();
}

bool Connection::may_process_request() const {
  return !closed_ && !draining_ && !executor_.waiting() && !pacer_.waiting() &&
         replies_.bytes() < context_.options.max_output_bytes;
}

bool Connection::is_stop(const modbus::ValidatedRequest& validated) const {
  return validated.verdict == Verdict::kRequest && context_.bank.is_stop(validated.request);
}

// Follows the peer's end as soon as the system knows of it: requests before it may be unread. A
// closed peer still gets its replies, and a turn of writes is still executed. False: the connection
// has ended.
bool Connection::follow_peer() {
  const auto noticed = protocols::notice_peer_end(stream_.next_layer().native_handle());
  if (noticed && noticed->error != boost::asio::error::eof) {
    close(noticed->error.message(), false);
    return false;
  }
  if (noticed && !std::exchange(peer_closed_, true)) last_writes_ = kRequestsPerTurn;
  return true;
}

// Drops the unread writes of a client that has closed, but for a last turn.
bool Connection::admits(const modbus::ValidatedRequest& validated) {
  const bool writes = validated.verdict == Verdict::kRequest && validated.request.is_write();
  if (!peer_closed_ || !writes || last_writes_-- > 0) return true;
  context_.log.warn(peer_ + " has closed: its unread writes are dropped");
  draining_ = true;
  return false;
}

void Connection::process() {
  if (closed_ || !follow_peer()) return;
  int processed = 0;
  while (processed < kRequestsPerTurn && may_process_request() && process_request()) ++processed;
  if (!reading_) reader_.compact();
  write();
  if (processed == kRequestsPerTurn && may_process_request() && !scheduled_) {
    scheduled_ = true;
    boost::asio::post(context_.io, [self = shared_from_this()] {
      self->scheduled_ = false;
      self->process();
    });
  }
  if (close_if_finished()) return;
  deadlines_.watch(shared_from_this());
  read();
}

bool Connection::close_if_finished() {
  const bool takes_no_more = draining_ || (ended_ && reader_.incomplete() && !scheduled_);
  if (!takes_no_more || executor_.waiting() || pacer_.waiting() || !replies_.empty()) return false;
  if (!broken_.empty()) {
    close(broken_, true);
  } else {
    close(draining_ && !peer_closed_ ? "the server stops" : "by the client", false);
  }
  return true;
}

bool Connection::process_request() {
  context_.bank.follow_scene();
  const modbus::ValidatedRequest validated = reader_.next();
  if (validated.verdict == Verdict::kIncomplete) {
    if (!reader_.rest().empty()) deadlines_.begin_request();
    return false;
  }
  deadlines_.end_request();
  if (validated.verdict == Verdict::kBroken) {
    break_stream(validated.reason);
    return false;
  }
  if (!admits(validated)) return false;
  const bool ignored = validated.verdict == Verdict::kIgnored;
  record_.received(validated.adu, ignored ? validated.reason : std::string_view());
  if (ignored) {
    context_.log.warn(peer_ +
                      " sent something that is not Modbus: " + std::string(validated.reason));
  } else {
    take(validated);
  }
  return true;
}

// Earlier requests still get their replies.
void Connection::break_stream(std::string_view reason) {
  broken_ = reason;
  record_.received(reader_.rest(), broken_);
  draining_ = true;
}

void Connection::take(const modbus::ValidatedRequest& validated) {
  slot_.used();
  deadlines_.restart_idle();
  const std::string refusal = refusal_of(validated);
  record_.request(validated.adu, refusal);
  join_time();
  if (!refusal.empty()) {
    reply(executor_.refuse(validated.adu, modbus::ExceptionCode::kIllegalFunction));
  } else if (!rate_.admit(Clock::now()) && !is_stop(validated)) {
    reply(executor_.refuse(validated.adu, modbus::ExceptionCode::kServerDeviceBusy));
  } else if (pacer_.joined()) {
    take_time(validated);
  } else {
    execute(validated);
    if (executor_.waiting()) context_.await_applied(shared_from_this());
  }
}

// The log has each function once a connection.
std::string Connection::refusal_of(const modbus::ValidatedRequest& validated) {
  const std::uint8_t function = validated.adu[modbus::kHeaderSize];
  const std::string refusal = rights_.refusal(function).value_or("");
  if (!refusal.empty() && !refused_functions_[function]) {
    refused_functions_.set(function);
    context_.log.warn(fmt::format("refused {} ({}): {}", peer_, rights_.identity(), refusal));
  }
  return refusal;
}

void Connection::join_time() {
  const std::string role = listener_name(context_.options);
  if (pacer_.joined() || !pacer_.is_registered(role)) return;
  pacer_.join({role, api::PacerKind::kClient, context_.options.listener.endpoint});
}

void Connection::take_time(const modbus::ValidatedRequest& validated) {
  const bool writes = validated.verdict == Verdict::kRequest && validated.request.is_write();
  std::vector<std::uint8_t> to_answer;
  if (writes) {
    execute(validated);
  } else {
    to_answer.assign(validated.adu.begin(), validated.adu.end());
  }
  if (closed_) return;
  const auto delay =
      protocols::injected_delay(*context_.source.latest(), faults::Kind::kModbusDelay);
  pacer_.after(pacer_.poll_period() + delay,
               [weak = weak_from_this(), to_answer = std::move(to_answer)] {
                 const auto self = weak.lock();
                 if (!self) return;
                 if (self->executor_.waiting()) return self->finish_write_in_time();
                 if (!to_answer.empty()) {
                   self->execute(modbus::validate_request(to_answer, self->context_.rules));
                 }
                 self->process();
               });
}

// A paused cell resumes the client before it has applied the write.
void Connection::finish_write_in_time() {
  context_.bank.refresh();
  if (poll_applied(Clock::now())) context_.await_applied(shared_from_this());
}

void Connection::execute(const modbus::ValidatedRequest& validated) {
  if (auto answer = executor_.execute(validated)) reply(std::move(*answer));
}

bool Connection::poll_applied(Clock::time_point now) {
  if (closed_ || !executor_.waiting() || !follow_peer()) return false;
  // Requests are executed in their order, so a stop would wait for the write before it.
  if (reader_.any_waiting([this](const auto& request) { return is_stop(request); })) {
    executor_.hurry();
  }
  auto answer = executor_.poll(now);
  if (!answer) return true;
  reply(std::move(*answer));
  process();
  // A pipelined write may already wait; it has registered for polling itself.
  return false;
}

void Connection::reply(std::vector<std::uint8_t> adu) {
  const api::SnapshotPtr now = context_.source.latest();
  if (protocols::injected(*now, faults::Kind::kModbusSilent)) return;
  record_.reply(adu);
  // A client that paces has waited for it in the cell's time.
  const auto delay = pacer_.joined() ? std::chrono::nanoseconds(0)
                                     : protocols::injected_delay(*now, faults::Kind::kModbusDelay);
  replies_.add(with_strays(std::move(adu), *now), delay, shared_from_this());
}

void Connection::write() {
  if (closed_ || pacer_.waiting()) return;
  const std::span<const std::uint8_t> bytes = replies_.begin_write();
  if (bytes.empty()) return;
  deadlines_.begin_write();
  boost::asio::async_write(stream_, boost::asio::buffer(bytes.data(), bytes.size()),
                           [self = shared_from_this()](const error_code& error, std::size_t) {
                             self->on_written(error);
                           });
}

void Connection::on_written(const error_code& error) {
  if (closed_) return;
  replies_.end_write();
  deadlines_.end_write();
  if (error) {
    close(error.message(), false);
    return;
  }
  process();
}

void Connection::on_deadline() {
  const std::string missed = deadlines_.missed(executor_.waiting() || pacer_.waiting());
  if (!missed.empty()) return close(missed, true);
  deadlines_.watch(shared_from_this());
}

}  // namespace aprsim::modbus_server
