#include "protocols/crcl/crcl_connection.hpp"

#include <exception>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <optional>
#include <sys/socket.h>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>

#include "crcl/command_codec.hpp"
#include "crcl/schema.hpp"
#include "crcl/status_codec.hpp"
#include "protocols/foreign_protocol.hpp"

namespace aprsim::crcl_server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr int kSendBufferBytes = 64 * 1024;
// A peer that pipelines gets no more than this before the others have their turn.
constexpr int kDocumentsPerTurn = 16;

}  // namespace

CrclConnection::CrclConnection(asio::ip::tcp::socket socket, std::string peer,
                               protocols::ConnectionPlaces::Place place,
                               protocols::ConnectionTrace trace, const CrclServerOptions& options,
                               CommandExecutor& executor, CrclCounters& counters,
                               std::function<void()> on_time, OnEnd on_end)
    : socket_(std::move(socket)),
      place_(std::move(place)),
      trace_(std::move(trace)),
      options_(options),
      executor_(executor),
      counters_(counters),
      on_time_(std::move(on_time)),
      on_end_(std::move(on_end)),
      caller_{std::make_shared<ConnectionSettings>(options.units, options.joints_in_degrees),
              std::move(peer)},
      framer_(crcl::Framer::for_commands(options.max_message_bytes, options.max_program_bytes)),
      write_timer_(socket_.get_executor()),
      idle_timer_(socket_.get_executor()),
      document_timer_(socket_.get_executor()),
      late_timer_(socket_.get_executor()),
      pause_timer_(socket_.get_executor()) {}

void CrclConnection::start() {
  error_code ignored;
  socket_.non_blocking(true, ignored);
  socket_.set_option(boost::asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
  executor_.log().info(caller_.peer + " connected");
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
  if (pacer_) options_.virtual_time->leave(*pacer_);
  pacer_.reset();
  then_ = nullptr;
  error_code ignored;
  write_timer_.cancel(ignored);
  idle_timer_.cancel(ignored);
  document_timer_.cancel(ignored);
  late_timer_.cancel(ignored);
  pause_timer_.cancel(ignored);
  socket_.shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  executor_.client_gone(caller_);
  trace_.closed(end_);
  on_end_(*this);
}

void CrclConnection::drop(const std::string& reason) {
  if (closed_) return;
  ++counters_.dropped;
  executor_.log().warn("closing " + caller_.peer + ": " + reason);
  end_ = reason;
  close();
}

void CrclConnection::shut_out() {
  if (pacer_) options_.virtual_time->shut_out(*pacer_);
  pacer_.reset();
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
    executor_.log().info(caller_.peer + " disconnected" +
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
  // What a web page has sent is nobody's command, and no error of the robot's.
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
// has too many statuses to take, on_writable() comes back here.
void CrclConnection::process() {
  for (int i = 0; i < kDocumentsPerTurn; ++i) {
    full_ = output_.size() + late_bytes_ >= options_.max_output_bytes;
    if (closed_ || draining_ || full_ || paused_ || then_) return;
    crcl::Result<std::optional<std::string>> document = framer_.next();
    if (!document) return fail_document(document.error());
    watch_document(!*document && framer_.buffered() > 0);
    if (!*document) return read();
    place_.used();
    ++counters_.commands;
    if (options_.virtual_time) join_time(false);
    if (const auto slow = executor_.faults().slow; slow.count() > 0) {
      if (!pacer_) return pause(*std::move(*document), slow);
      return after(slow, [this, held = *std::move(*document)] { take(held); });
    }
    take(**document);
  }
  asio::post(socket_.get_executor(), [self = shared_from_this()] { self->process(); });
}

void CrclConnection::take(const std::string& document) {
  try {
    trace_.received(document);
    handle(document);
  } catch (const std::exception& problem) {
    drop(problem.what());  // this peer's loss, not the others'
  }
}

// An injected fault: the document is taken later, and nothing after it before.
void CrclConnection::pause(std::string document, std::chrono::nanoseconds time) {
  paused_ = true;
  pause_timer_.expires_after(time);
  pause_timer_.async_wait(
      [self = shared_from_this(), document = std::move(document)](const error_code& cancelled) {
        self->paused_ = false;
        if (cancelled || self->closed_ || self->draining_) return;
        self->take(document);
        self->process();
      });
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

void CrclConnection::handle(const std::string& document) {
  // Who watches polls sees every document, so it is read anew.
  if (document == get_status_ && !polls_tapped()) return poll();
  if (polls_tapped()) received_ = std::chrono::steady_clock::now();
  if (options_.strict) {
    if (const auto fault = crcl::schema_fault(document)) {
      tap_error(*fault, document);
      return fail_document(*fault);
    }
  }
  return framer_.last_root() == 0 ? handle_command(document) : handle_program(document);
}

void CrclConnection::handle_program(const std::string& document) {
  crcl::Result<crcl::Program> program = crcl::decode_program(document, options_.max_program_bytes);
  if (!program) {
    tap_error(program.error(), document);
    return handle_undecodable(program.error());
  }
  tap_command("CRCLProgramType", 0, "", document);
  executor_.execute(std::move(*program), caller_);
}

void CrclConnection::handle_command(const std::string& document) {
  const crcl::Result<crcl::CommandInstance> instance =
      crcl::decode_command(document, options_.max_message_bytes);
  if (!instance) {
    tap_error(instance.error(), document);
    return handle_undecodable(instance.error());
  }
  tap_command(std::string(crcl::type_name(instance->command.body)), instance->command.id, "",
              document);
  if (std::holds_alternative<crcl::GetStatus>(instance->command.body)) {
    get_status_ = document;
    return poll();
  }
  executor_.execute(*instance, caller_);
}

void CrclConnection::handle_undecodable(const crcl::Error& error) {
  if (error.kind != crcl::ErrorKind::kBadValue) return fail_document(error);
  // One status answers each GetStatus, whatever its id looks like.
  if (error.command_type == "GetStatusType") return poll();
  executor_.refuse(error.command_type, error.command_id.value_or(0), error.message());
}

void CrclConnection::fail_document(const crcl::Error& error) {
  const std::string reason = "Bad document from " + caller_.peer + ": " + error.message();
  executor_.bad_document(reason);
  ++counters_.dropped;
  executor_.log().warn("closing " + caller_.peer + ": " + error.message());
  end_ = error.message();
  drain();
}

// Polls are the clock: in virtual time each takes its period, and its status is of the end of that.
void CrclConnection::poll() {
  if (options_.virtual_time) join_time(true);
  if (!pacer_) return answer_status();
  after(options_.virtual_time->poll_period() + executor_.faults().late_status,
        [this] { answer_status(); });
}

// Where pacers are declared, with the first document; else with the first poll.
void CrclConnection::join_time(bool polls) {
  const std::string& role = executor_.name();
  if (pacer_ || !(polls || options_.virtual_time->declares(role))) return;
  pacer_ = options_.virtual_time->join(
      {role, api::PacerKind::kClient, options_.endpoint},
      [executor = socket_.get_executor(), connection = weak_from_this()] {
        asio::post(executor, [connection] {
          if (const auto open = connection.lock()) open->on_reached();
        });
      });
}

// Nothing of this connection is handled before.
void CrclConnection::after(SimTime span, std::function<void()> then) {
  then_ = std::move(then);
  options_.virtual_time->ask(*pacer_, span);
  watch_end();
}

// Nothing is read meanwhile, but a client that is gone shall not have others left behind.
void CrclConnection::watch_end() {
  if (std::exchange(watches_end_, true)) return;
  socket_.async_wait(
      asio::ip::tcp::socket::wait_read, [self = shared_from_this()](const error_code& failed) {
        self->watches_end_ = false;
        if (failed || self->closed_ || !self->then_ || !self->pacer_) return;
        char byte = 0;
        error_code error;
        self->socket_.receive(asio::buffer(&byte, 1), asio::socket_base::message_peek, error);
        if (error == asio::error::would_block) return self->watch_end();
        if (error) self->options_.virtual_time->finish(*self->pacer_);
      });
}

void CrclConnection::on_reached() {
  on_time_();
  if (closed_ || draining_ || !then_) return;
  const auto then = std::exchange(then_, nullptr);
  try {
    then();
  } catch (const std::exception& problem) {
    drop(problem.what());
  }
  // It may wait for another instant already.
  if (!then_) process();
}

void CrclConnection::answer_status() {
  const crcl::Status status = executor_.status(*caller_.settings);
  const std::string document = crcl::encode_status(status);
  tap_status(status.command, document);
  ++counters_.statuses;
  const PortFaults faults = executor_.faults();
  if (faults.half_document) {
    output_ += document.substr(0, document.size() / 2);
    trace_.sent(document.substr(0, document.size() / 2));
    if (!blocked_) flush();
    end_ = "an injected fault";
    return drain();
  }
  if (!pacer_ && (faults.late_status.count() > 0 || !late_.empty())) {
    return send_later(document, faults.late_status);
  }
  output_ += document;
  // On its way before it is traced.
  if (!blocked_) flush();
  counters_.answer_times.add(std::chrono::steady_clock::now() - read_at_);
  trace_.sent(document);
}

// An injected fault: in their order, each at its time.
void CrclConnection::send_later(std::string document, std::chrono::nanoseconds time) {
  late_bytes_ += document.size();
  late_.push_back({std::chrono::steady_clock::now() + time, std::move(document)});
  if (late_.size() == 1) send_due();
}

void CrclConnection::send_due() {
  if (closed_) return;
  while (!late_.empty() && late_.front().due <= std::chrono::steady_clock::now()) {
    late_bytes_ -= late_.front().document.size();
    trace_.sent(late_.front().document);
    output_ += late_.front().document;
    late_.pop_front();
  }
  if (!output_.empty() && !blocked_) flush();
  if (closed_) return;
  if (!late_.empty()) {
    late_timer_.expires_at(late_.front().due);
    late_timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
      if (!cancelled) self->send_due();
    });
  } else if (draining_ && output_.empty()) {
    return close();
  }
  if (full_ && output_.size() + late_bytes_ < options_.max_output_bytes) process();
}

void CrclConnection::tap_error(const crcl::Error& error, const std::string& document) {
  tap_command(error.command_type, error.command_id.value_or(0), error.message(), document);
}

void CrclConnection::tap_command(std::string type, std::int64_t id, std::string fault,
                                 const std::string& document) {
  if (!options_.tap) return;
  const bool poll = type == "GetStatusType" && fault.empty();
  if (poll && !polls_tapped()) return;
  options_.tap->note({.source = executor_.name(),
                      .peer = caller_.peer,
                      .from_client = true,
                      .poll = poll,
                      .time = std::chrono::system_clock::now(),
                      .type = std::move(type),
                      .id = id,
                      .state = std::move(fault),
                      .data = document});
}

// The first status that tells the end of a command stands with the commands, without its document.
void CrclConnection::tap_status(const crcl::CommandStatus& status, const std::string& document) {
  if (!options_.tap) return;
  protocols::WireEvent event{.source = executor_.name(),
                             .peer = caller_.peer,
                             .time = std::chrono::system_clock::now(),
                             .type = "CRCLStatusType",
                             .id = status.command_id,
                             .state = std::string(crcl::name_of(status.state))};
  if (executor_.first_to_tell_end(status.state)) {
    protocols::WireEvent end = event;
    if (status.description) end.state += ": " + *status.description;
    options_.tap->note(std::move(end));
  }
  if (!polls_tapped()) return;
  event.poll = true;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - received_;
  event.latency_s = since.count();
  event.data = document;
  options_.tap->note(std::move(event));
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
  if (closed_) return;
  if (draining_ && all_sent()) return close();
  if (full_ && output_.size() + late_bytes_ < options_.max_output_bytes) process();
}

}  // namespace aprsim::crcl_server
