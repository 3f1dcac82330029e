#include "protocols/crcl/crcl_session.hpp"

#include <exception>
#include <type_traits>
#include <utility>

#include "crcl/command_codec.hpp"
#include "crcl/schema.hpp"
#include "crcl/status_codec.hpp"

namespace aprsim::crcl_server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// Assumed size of a status without a document.
constexpr std::size_t kUsualStatusBytes = 2048;

}  // namespace

CrclSession::CrclSession(const CrclServerOptions& options, CommandExecutor& executor,
                         CrclCounters& counters, const asio::any_io_executor& io, std::string peer,
                         api::VirtualTime* virtual_time, std::function<void()> on_time,
                         SessionWire& wire)
    : options_(options),
      executor_(executor),
      counters_(counters),
      on_time_(std::move(on_time)),
      wire_(wire),
      caller_{std::make_shared<ConnectionSettings>(options.units, options.joints_in_degrees),
              std::move(peer)},
      late_(io, {[this](Answer answer) { wire_.send(std::move(answer)); },
                 [this] { wire_.on_room(); }}),
      pacer_(virtual_time, io),
      pause_timer_(io) {
  if (options.wait_for_end_effector) caller_.settings->wait_for_end_effector();
}

void CrclSession::close() {
  pacer_.leave();
  late_.close();
  error_code ignored;
  pause_timer_.cancel(ignored);
}

void CrclSession::take(Received received, std::chrono::steady_clock::time_point read_at) {
  read_at_ = read_at;
  ++counters_.commands;
  join_time(false);
  if (const auto slow = executor_.faults().slow; slow.count() > 0) {
    if (!pacer_.joined()) return pause(std::move(received), slow);
    return after(slow, [this, held = std::move(received)] { handle(held); });
  }
  guarded([&] { handle(received); });
}

// An exception ends this peer's connection only.
void CrclSession::guarded(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& problem) {
    wire_.drop(problem.what());
  }
}

// An injected fault: the document is processed later, and later ones after it.
void CrclSession::pause(Received received, std::chrono::nanoseconds time) {
  paused_ = true;
  pause_timer_.expires_after(time);
  pause_timer_.async_wait(
      [this, hold = wire_.hold(), received = std::move(received)](const error_code& cancelled) {
        paused_ = false;
        if (cancelled || wire_.ended()) return;
        guarded([&] { handle(received); });
        wire_.on_taken();
      });
}

void CrclSession::handle(const Received& received) {
  if (const auto* command = std::get_if<CommandDocument>(&received)) {
    // While polls are tapped, every document is decoded.
    if (command->text == get_status_ && !polls_tapped()) return poll();
  }
  if (polls_tapped()) received_ = std::chrono::steady_clock::now();
  std::visit(
      [this](const auto& sent) {
        using Sent = std::decay_t<decltype(sent)>;
        if constexpr (std::is_same_v<Sent, crcl::Result<crcl::CommandInstance>>) {
          const bool shown = options_.strict || options_.tap;
          const std::string document = shown && sent ? crcl::encode_command(*sent) : "";
          if (!sent || !refused_by_schema(document)) handle_command(sent, document);
        } else if constexpr (std::is_same_v<Sent, crcl::Result<crcl::Program>>) {
          const bool shown = options_.strict || options_.tap;
          const std::string document = shown && sent ? crcl::encode_program(*sent) : "";
          if (!sent || !refused_by_schema(document)) handle_program(sent, document);
        } else if (!refused_by_schema(sent.text)) {
          handle_document(sent);
        }
      },
      received);
}

bool CrclSession::refused_by_schema(const std::string& document) {
  if (!options_.strict) return false;
  const auto fault = crcl::schema_fault(document);
  if (!fault) return false;
  tap_error(*fault, document);
  fail(*fault);
  return true;
}

void CrclSession::handle_document(const CommandDocument& document) {
  const auto command = crcl::decode_command(document.text, options_.max_message_bytes);
  if (command && std::holds_alternative<crcl::GetStatus>(command->command.body)) {
    get_status_ = document.text;
  }
  handle_command(command, document.text);
}

void CrclSession::handle_document(const ProgramDocument& document) {
  handle_program(crcl::decode_program(document.text, options_.max_program_bytes), document.text);
}

void CrclSession::handle_command(const crcl::Result<crcl::CommandInstance>& command,
                                 const std::string& document) {
  if (!command) {
    tap_error(command.error(), document);
    return handle_undecodable(command.error());
  }
  tap_command(std::string(crcl::type_name(command->command.body)), command->command.id, "",
              document);
  if (std::holds_alternative<crcl::GetStatus>(command->command.body)) return poll();
  if (admits_command()) executor_.execute(*command, caller_);
}

void CrclSession::handle_program(const crcl::Result<crcl::Program>& program,
                                 const std::string& document) {
  if (!program) {
    tap_error(program.error(), document);
    return handle_undecodable(program.error());
  }
  tap_command("CRCLProgramType", 0, "", document);
  if (admits_command()) executor_.execute(*program, caller_);
}

bool CrclSession::admits_command() { return wire_.admits_command(); }

void CrclSession::handle_undecodable(const crcl::Error& error) {
  if (error.kind != crcl::ErrorKind::kBadValue) return fail(error);
  // One status answers each GetStatus, whatever its id looks like.
  if (error.command_type == "GetStatusType") return poll();
  if (!admits_command()) return;
  executor_.refuse(error.command_type, error.command_id.value_or(0), error.message());
}

void CrclSession::fail(const crcl::Error& error) {
  executor_.bad_document("Bad document from " + caller_.peer + ": " + error.message());
  ++counters_.dropped;
  executor_.log().warn("closing " + caller_.peer + ": " + error.message());
  wire_.refuse(error.message());
}

// Polls are the clock: in virtual time each takes its period, and its status is of the end of it.
void CrclSession::poll() {
  join_time(true);
  if (!pacer_.joined()) return answer_status();
  after(pacer_.poll_period() + executor_.faults().late_status, [this] { answer_status(); });
}

// Declared pacers join with the first document, others with the first poll.
void CrclSession::join_time(bool polls) {
  const std::string& role = executor_.name();
  if (!polls && !pacer_.is_registered(role)) return;
  pacer_.join({role, api::PacerKind::kClient, options_.listener.endpoint});
}

// No other document of this session is processed before.
void CrclSession::after(SimTime span, std::function<void()> then) {
  pacer_.after(span,
               [this, wire = std::weak_ptr<SessionWire>(wire_.hold()), then = std::move(then)] {
                 const auto open = wire.lock();
                 if (!open) return;
                 on_time_();
                 if (wire_.ended()) return;
                 guarded(then);
                 // It may wait for another instant already.
                 if (!pacer_.waiting()) wire_.on_taken();
               });
  wire_.watch_end();
}

void CrclSession::answer_status() {
  Answer answer{executor_.status(*caller_.settings), {}};
  if (wire_.carries_documents() || polls_tapped()) {
    // NIST's servers send an empty description where there is none.
    answer.status.command.description = answer.status.command.description.value_or("");
    answer.document = crcl::encode_status(answer.status);
  }
  tap_status(answer.status.command, answer.document);
  ++counters_.statuses;
  const PortFaults faults = executor_.faults();
  if (faults.half_document) return wire_.send_half(std::move(answer));
  // A client that paces has waited for it in the cell's time.
  const auto delay = pacer_.joined() ? std::chrono::nanoseconds(0) : faults.late_status;
  if (late_.must_wait(delay)) {
    const std::size_t bytes =
        wire_.carries_documents() ? answer.document.size() : kUsualStatusBytes;
    return late_.add(std::move(answer), bytes, delay, wire_.hold());
  }
  wire_.send(std::move(answer));
  counters_.answer_times.add(std::chrono::steady_clock::now() - read_at_);
}

void CrclSession::tap_error(const crcl::Error& error, const std::string& document) {
  tap_command(error.command_type, error.command_id.value_or(0), error.message(), document);
}

void CrclSession::tap_command(std::string type, std::int64_t id, std::string fault,
                              const std::string& document) {
  if (!options_.tap) return;
  const bool poll = type == "GetStatusType" && fault.empty();
  if (poll && !polls_tapped()) return;
  options_.tap->record({.source = executor_.name(),
                        .peer = caller_.peer,
                        .from_client = true,
                        .poll = poll,
                        .time = std::chrono::system_clock::now(),
                        .type = std::move(type),
                        .id = id,
                        .state = std::move(fault),
                        .data = document});
}

// The first status that reports the end of a command is listed with the commands, without document.
void CrclSession::tap_status(const crcl::CommandStatus& status, const std::string& document) {
  if (!options_.tap) return;
  protocols::WireEvent event{.source = executor_.name(),
                             .peer = caller_.peer,
                             .time = std::chrono::system_clock::now(),
                             .type = "CRCLStatusType",
                             .id = status.command_id,
                             .state = std::string(crcl::name_of(status.state))};
  if (executor_.first_to_tell_end(status.state)) {
    protocols::WireEvent end = event;
    if (status.description && !status.description->empty()) {
      end.state += ": " + *status.description;
    }
    options_.tap->record(std::move(end));
  }
  if (!polls_tapped()) return;
  event.poll = true;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - received_;
  event.latency_s = since.count();
  event.data = document;
  options_.tap->record(std::move(event));
}

}  // namespace aprsim::crcl_server
