#include "protocols/modbus/connection.hpp"

#include <algorithm>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>

#include "protocols/modbus/wire_event.hpp"
#include "protocols/net/foreign_protocol.hpp"
#include "protocols/ports/wire_faults.hpp"

namespace aprsim::modbus_server {
namespace {

using modbus::Verdict;

// Requests of one connection answered before the others get their turn.
constexpr int kRequestsPerTurn = 16;

// Transaction and protocol id: less does not tell Modbus from other protocols.
constexpr std::size_t kProtocolBytes = 4;

// What the kernel keeps for a client that does not read.
constexpr int kSendBufferBytes = 64 * 1024;

std::string millis(std::chrono::milliseconds time) { return std::to_string(time.count()) + " ms"; }

std::string_view text_of(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Connection::Connection(boost::asio::ip::tcp::socket socket, std::string peer,
                       protocols::ConnectionPlaces::Place place, ListenerContext& context)
    : socket_(std::move(socket)),
      peer_(std::move(peer)),
      place_(std::move(place)),
      context_(context),
      trace_(context.options.trace, context.source, protocols::WireKind::kModbus, "modbus", peer_),
      timer_(context.io),
      rate_(context.options.max_requests_per_s),
      late_timer_(context.io) {}

void Connection::start() {
  boost::system::error_code ignored;
  socket_.set_option(boost::asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
  if (context_.options.idle_timeout.count() > 0) {
    idle_due_ = Clock::now() + context_.options.idle_timeout;
  }
  context_.log.info(peer_ + " connected");
  set_timer();
  read();
}

void Connection::drain() {
  draining_ = true;
  asked_ = false;
  if (pacer_ && waiting_) context_.await_applied(shared_from_this());
  process();
}

void Connection::close(std::string_view why, bool fault) {
  if (closed_) return;
  closed_ = true;
  waiting_.reset();
  if (pacer_) context_.options.virtual_time->leave(*pacer_);
  pacer_.reset();
  const std::string line = peer_ + (fault ? " dropped: " : " closed: ") + std::string(why);
  if (fault) {
    ++context_.counters.dropped;
    context_.log.warn(line);
  } else {
    context_.log.info(line);
  }
  boost::system::error_code ignored;
  socket_.close(ignored);
  timer_.cancel();
  late_timer_.cancel();
  trace_.closed(why);
  context_.closed(*this);
}

void Connection::read() {
  if (reading_ || ended_ || draining_ || closed_ || in_size_ == in_.size()) return;
  reading_ = true;
  socket_.async_read_some(
      boost::asio::buffer(in_.data() + in_size_, in_.size() - in_size_),
      [self = shared_from_this()](const boost::system::error_code& error, std::size_t size) {
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
  in_size_ += size;
  if (!heard_ && in_size_ >= kProtocolBytes) {
    heard_ = true;
    // In these, a Modbus master would name protocol 0.
    const std::string_view protocol =
        protocols::foreign_protocol({reinterpret_cast<const char*>(in_.data()), in_size_});
    if (!protocol.empty() && (in_[2] != 0 || in_[3] != 0)) {
      return close("it speaks " + std::string(protocol) + ", not Modbus", true);
    }
  }
  process();
}

void Connection::on_end_of_stream(const boost::system::error_code& error) {
  if (error != boost::asio::error::eof) {
    close(error.message(), false);
    return;
  }
  // The peer sends no more; what it has asked for completely is still answered.
  ended_ = true;
  process();
}

bool Connection::may_process_request() const {
  return !closed_ && !draining_ && !waiting_ && !asked_ &&
         out_.size() + sending_.size() + late_bytes_ < context_.options.max_output_bytes;
}

void Connection::process() {
  if (closed_) return;
  int processed = 0;
  while (processed < kRequestsPerTurn && may_process_request() && process_request()) ++processed;
  // The bytes move only while no read is under way into the space behind them.
  if (!reading_ && in_used_ > 0) {
    std::copy(in_.begin() + static_cast<std::ptrdiff_t>(in_used_),
              in_.begin() + static_cast<std::ptrdiff_t>(in_size_), in_.begin());
    in_size_ -= in_used_;
    in_used_ = 0;
  }
  send();
  if (processed == kRequestsPerTurn && may_process_request() && !scheduled_) {
    scheduled_ = true;
    boost::asio::post(context_.io, [self = shared_from_this()] {
      self->scheduled_ = false;
      self->process();
    });
  }
  if (close_if_finished()) return;
  set_timer();
  read();
}

bool Connection::close_if_finished() {
  const bool takes_no_more = draining_ || (ended_ && incomplete_ && !scheduled_);
  if (!takes_no_more || waiting_ || asked_ || !out_.empty() || !sending_.empty() ||
      !late_.empty()) {
    return false;
  }
  if (!broken_.empty()) {
    close(broken_, true);
  } else {
    close(draining_ ? "the server stops" : "by the client", false);
  }
  return true;
}

bool Connection::process_request() {
  const modbus::ValidatedRequest validated = modbus::validate_request(
      std::span(in_).subspan(in_used_, in_size_ - in_used_), context_.rules);
  incomplete_ = validated.verdict == Verdict::kIncomplete;
  if (incomplete_) {
    if (in_size_ > in_used_ && request_due_ == kNever) {
      request_due_ = Clock::now() + context_.options.partial_timeout;
    }
    return false;
  }
  request_due_ = kNever;
  if (validated.verdict == Verdict::kBroken) {
    // What was asked for before still gets its answers.
    broken_ = validated.reason;
    trace_.received(text_of(std::span(in_).subspan(in_used_, in_size_ - in_used_)), broken_);
    draining_ = true;
    return false;
  }
  in_used_ += validated.adu.size();
  trace_.received(text_of(validated.adu),
                  validated.verdict == Verdict::kIgnored ? validated.reason : std::string_view());
  if (validated.verdict == Verdict::kIgnored) {
    context_.log.warn(peer_ +
                      " sent something that is not Modbus: " + std::string(validated.reason));
    return true;
  }
  place_.used();
  ++context_.counters.requests;
  received_ = Clock::now();
  if (context_.options.idle_timeout.count() > 0) {
    idle_due_ = Clock::now() + context_.options.idle_timeout;
  }
  tap(true, validated.adu);
  if (context_.options.virtual_time) join_time();
  if (rate_.admit(Clock::now())) {
    if (pacer_) {
      take_time(validated);
    } else {
      handle(validated);
    }
  } else {
    refuse(validated.adu, modbus::ExceptionCode::kServerDeviceBusy);
  }
  return true;
}

void Connection::join_time() {
  constexpr const char* kRole = "modbus";
  api::VirtualTime& time = *context_.options.virtual_time;
  if (pacer_ || !time.is_registered(kRole)) return;
  pacer_ = time.join({kRole, api::PacerKind::kClient, context_.options.endpoint},
                     [&io = context_.io, connection = weak_from_this()] {
                       boost::asio::post(io, [connection] {
                         if (const auto open = connection.lock()) open->on_reached();
                       });
                     });
}

void Connection::take_time(const modbus::ValidatedRequest& validated) {
  asked_ = true;
  if (validated.verdict == Verdict::kRequest && validated.request.is_write()) {
    handle(validated);
  } else {
    to_answer_.assign(validated.adu.begin(), validated.adu.end());
  }
  if (closed_) return;
  const auto delay =
      protocols::injected_delay(*context_.source.latest(), faults::Kind::kModbusDelay);
  context_.options.virtual_time->request_until(
      *pacer_, context_.options.virtual_time->poll_period() + delay);
}

void Connection::on_reached() {
  if (closed_ || !std::exchange(asked_, false)) return;
  if (waiting_) {
    context_.device.refresh();
    // A cell that is paused lets go before it has applied it.
    if (poll_applied(Clock::now())) context_.await_applied(shared_from_this());
    return;
  }
  const std::vector<std::uint8_t> adu = std::exchange(to_answer_, {});
  if (!adu.empty()) handle(modbus::validate_request(adu, context_.rules));
  process();
}

void Connection::handle(const modbus::ValidatedRequest& validated) {
  const api::SnapshotPtr now = context_.source.latest();
  const auto* exceptions =
      now->faults ? now->faults->active(faults::Kind::kModbusExceptions) : nullptr;
  if (exceptions != nullptr) {
    const double code = api::InjectedFaults::value(*exceptions, "code");
    return refuse(validated.adu, static_cast<modbus::ExceptionCode>(static_cast<int>(code)));
  }
  if (validated.verdict == Verdict::kRefused) {
    refuse(validated.adu, validated.exception);
  } else if (validated.verdict == Verdict::kIdentification) {
    reply(modbus::identification_reply(validated.adu, validated.identification));
  } else {
    execute(validated);
  }
}

void Connection::execute(const modbus::ValidatedRequest& validated) {
  context_.device.refresh();
  if (!validated.request.is_write()) {
    answer(validated.adu);
    return;
  }
  const auto ticket = context_.device.write(validated.request);
  if (!ticket) {
    refuse(validated.adu, ticket.error());
  } else if (*ticket == 0) {
    answer(validated.adu);
  } else {
    waiting_ = WaitingWrite{*ticket,
                            Clock::now() + context_.options.apply_deadline,
                            {validated.adu.begin(), validated.adu.end()}};
    if (!pacer_) context_.await_applied(shared_from_this());
  }
}

bool Connection::poll_applied(Clock::time_point now) {
  if (closed_ || !waiting_) return false;
  const bool applied = context_.device.applied(waiting_->ticket);
  if (!applied && now < waiting_->deadline) return true;
  const std::vector<std::uint8_t> adu = std::move(waiting_->adu);
  waiting_.reset();
  if (applied) {
    answer(adu);
  } else {
    context_.log.warn(peer_ + ": the simulation did not confirm a write within " +
                      millis(context_.options.apply_deadline));
    refuse(adu, modbus::ExceptionCode::kServerDeviceFailure);
  }
  process();
  // A pipelined write may have begun to wait at once; it has asked to be polled by itself.
  return false;
}

void Connection::answer(std::span<const std::uint8_t> adu) {
  const auto built = context_.replies.build(adu, context_.device.image());
  if (built.empty()) {
    context_.log.warn(peer_ + ": no reply could be encoded");
    refuse(adu, modbus::ExceptionCode::kServerDeviceFailure);
    return;
  }
  reply(built);
}

void Connection::refuse(std::span<const std::uint8_t> adu, modbus::ExceptionCode code) {
  ++context_.counters.exceptions;
  if (auto* const refusals = context_.options.refusals) {
    const int function = adu.size() > 7 ? adu[7] : 0;
    refusals->refused(context_.log.name(), "function " + std::to_string(function) + " of " + peer_ +
                                               ": exception " +
                                               std::to_string(static_cast<int>(code)));
  }
  reply(modbus::exception_reply(adu, code).bytes);
}

void Connection::reply(std::span<const std::uint8_t> adu) {
  const api::SnapshotPtr now = context_.source.latest();
  if (protocols::injected(*now, faults::Kind::kModbusSilent)) return;
  tap(false, adu);
  context_.counters.answer_times.add(Clock::now() - received_);
  std::vector<std::uint8_t> bytes;
  if (protocols::injected(*now, faults::Kind::kModbusStray)) {
    // The same under a transaction number that nobody has given.
    bytes.assign(adu.begin(), adu.end());
    bytes[0] ^= 0x5A;
  }
  bytes.insert(bytes.end(), adu.begin(), adu.end());
  // A client that paces has waited for it in the cell's time.
  const auto delay = pacer_ ? std::chrono::nanoseconds(0)
                            : protocols::injected_delay(*now, faults::Kind::kModbusDelay);
  if (delay.count() == 0 && late_.empty()) {
    out_.insert(out_.end(), bytes.begin(), bytes.end());
    return trace_sent(bytes);
  }
  late_bytes_ += bytes.size();
  late_.push_back({Clock::now() + delay, std::move(bytes)});
  if (late_.size() > 1) return;
  late_timer_.expires_at(late_.front().due);
  late_timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
    if (!error) self->send_due();
  });
}

void Connection::send_due() {
  if (closed_) return;
  while (!late_.empty() && late_.front().due <= Clock::now()) {
    late_bytes_ -= late_.front().adu.size();
    out_.insert(out_.end(), late_.front().adu.begin(), late_.front().adu.end());
    trace_sent(late_.front().adu);
    late_.pop_front();
  }
  if (!late_.empty()) {
    late_timer_.expires_at(late_.front().due);
    late_timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
      if (!error) self->send_due();
    });
  }
  process();
}

void Connection::tap(bool from_client, std::span<const std::uint8_t> adu) {
  protocols::WireTap* const tap = context_.options.tap;
  if (!tap) return;
  protocols::WireEvent event = wire_event(adu);
  if (event.poll && !tap->wants_polls()) return;
  const std::chrono::duration<double> since = Clock::now() - received_;
  event.peer = peer_;
  event.from_client = from_client;
  event.time = std::chrono::system_clock::now();
  if (!from_client) event.latency_s = since.count();
  tap->note(std::move(event));
}

void Connection::trace_sent(std::span<const std::uint8_t> adus) {
  constexpr std::size_t kLengthAt = 4, kLengthEnd = 6;  // in the MBAP header
  while (adus.size() > kLengthEnd) {
    const std::size_t rest = adus[kLengthAt] * 256U + adus[kLengthAt + 1];
    const std::size_t size = std::min(adus.size(), kLengthEnd + rest);
    trace_.sent(text_of(adus.first(size)));
    adus = adus.subspan(size);
  }
}

void Connection::send() {
  if (closed_ || asked_ || out_.empty() || !sending_.empty()) return;
  std::swap(out_, sending_);
  reply_due_ = Clock::now() + context_.options.write_timeout;
  boost::asio::async_write(socket_, boost::asio::buffer(sending_),
                           [self = shared_from_this()](const boost::system::error_code& error,
                                                       std::size_t) { self->on_sent(error); });
}

void Connection::on_sent(const boost::system::error_code& error) {
  if (closed_) return;
  sending_.clear();
  reply_due_ = kNever;
  if (error) {
    close(error.message(), false);
    return;
  }
  process();
}

void Connection::set_timer() {
  // The timer is left alone when it fires early: it finds nothing due and is set anew. That way an
  // ordinary request costs no timer operation.
  const Clock::time_point due = std::min({request_due_, reply_due_, idle_due_});
  if (closed_ || due >= timer_at_) return;
  timer_at_ = due;
  timer_.expires_at(due);
  timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
    if (error || self->closed_) return;
    self->timer_at_ = kNever;
    self->on_timer();
  });
}

void Connection::on_timer() {
  const Clock::time_point now = Clock::now();
  const ModbusServerOptions& options = context_.options;
  if (now >= request_due_) {
    close("a request stayed incomplete for " + millis(options.partial_timeout), true);
  } else if (now >= reply_due_) {
    close("it did not take its replies for " + millis(options.write_timeout), true);
  } else if (now >= idle_due_ && !waiting_ && !asked_) {
    close("no request for " + millis(options.idle_timeout), true);
  } else {
    if (now >= idle_due_) idle_due_ = now + options.idle_timeout;
    set_timer();
  }
}

}  // namespace aprsim::modbus_server
