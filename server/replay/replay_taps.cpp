#include "server/replay/replay_taps.hpp"

#include <chrono>
#include <cstdint>
#include <utility>

#include "aprsim/v1/web.pb.h"
#include "crcl/command_codec.hpp"
#include "crcl/status_codec.hpp"
#include "protocols/modbus/wire_event.hpp"
#include "protocols/web/http/request_text.hpp"

namespace aprsim::server {
namespace {

/// More records than a second has; beyond that, records of a paused run are shown early.
constexpr std::size_t kMostWaiting = 20'000;

bool has(const std::string& document, const char* word) {
  return document.find(word) != std::string::npos;
}

}  // namespace

void ReplayTaps::Clock::set(const v1::JournalWire& wire) {
  auto now = std::make_shared<api::Snapshot>();
  now->epoch = wire.time().epoch();
  now->time = std::chrono::seconds(wire.sim_time().seconds()) +
              std::chrono::nanoseconds(wire.sim_time().nanos());
  now_ = std::move(now);
}

void ReplayTaps::add(const v1::JournalRecord& record) {
  if (!record.has_wire()) return;
  const auto content = record.wire().content();
  if (content != v1::WIRE_CONTENT_RECEIVED && content != v1::WIRE_CONTENT_SENT) return;
  waiting_.push_back(record);
  if (waiting_.size() <= kMostWaiting) return;
  show(waiting_.front());
  waiting_.pop_front();
}

void ReplayTaps::reach(world::RunTime time) {
  while (!waiting_.empty()) {
    const v1::JournalTime& at = waiting_.front().wire().time();
    if (at.epoch() > time.epoch || (at.epoch() == time.epoch && at.step() > time.step)) return;
    show(waiting_.front());
    waiting_.pop_front();
  }
}

void ReplayTaps::finish() {
  for (; !waiting_.empty(); waiting_.pop_front()) show(waiting_.front());
}

void ReplayTaps::show(const v1::JournalRecord& record) {
  const v1::JournalWire& wire = record.wire();
  clock_.set(wire);
  const auto wall = std::chrono::seconds(record.wall_time().seconds()) +
                    std::chrono::nanoseconds(record.wall_time().nanos());
  protocols::WireEvent event{
      .source = wire.listener(),
      .peer = wire.peer(),
      .from_client = wire.content() == v1::WIRE_CONTENT_RECEIVED,
      .time = std::chrono::system_clock::time_point(
          std::chrono::duration_cast<std::chrono::system_clock::duration>(wall))};
  switch (wire.kind()) {
    case v1::WIRE_KIND_CRCL:
      return show_crcl(wire, std::move(event));
    case v1::WIRE_KIND_MODBUS:
      return show_modbus(wire, std::move(event));
    case v1::WIRE_KIND_WEB:
      return show_page(wire, std::move(event));
    default:
      return;
  }
}

void ReplayTaps::show_crcl(const v1::JournalWire& wire, protocols::WireEvent event) {
  const std::string& document = wire.data();
  event.data = document;
  if (!event.from_client) {
    event.type = "CRCLStatusType";
    const bool ends =
        !ended_[event.source] && (has(document, "CRCL_Done") || has(document, "CRCL_Error"));
    if (!ends && !crcl_.wants_polls()) return;
    const auto status = crcl::decode_status(document);
    if (!status) return;
    event.id = status->command.command_id;
    event.state = std::string(crcl::name_of(status->command.state));
    // The first status that reports the end of a command is listed with the commands, without its
    // document.
    if (ends) {
      ended_[event.source] = true;
      protocols::WireEvent end = event;
      end.data.clear();
      if (status->command.description) end.state += ": " + *status->command.description;
      crcl_.record(std::move(end));
    }
    event.poll = true;
    return crcl_.record(std::move(event));
  }
  event.state = wire.text();
  if (has(document, "<CRCLProgram")) {
    event.type = "CRCLProgramType";
  } else if (const auto command = crcl::decode_command(document)) {
    event.type = std::string(crcl::type_name(command->command.body));
    event.id = command->command.id;
    event.poll = std::holds_alternative<crcl::GetStatus>(command->command.body);
  } else {
    event.type = command.error().command_type;
    event.id = command.error().command_id.value_or(0);
    event.state = command.error().message();
  }
  if (!event.poll) ended_[event.source] = false;
  crcl_.record(std::move(event));
}

void ReplayTaps::show_modbus(const v1::JournalWire& wire, protocols::WireEvent event) {
  const std::string& unit = wire.data();
  protocols::WireEvent shown =
      modbus_server::wire_event({reinterpret_cast<const std::uint8_t*>(unit.data()), unit.size()});
  shown.source = std::move(event.source);
  shown.peer = std::move(event.peer);
  shown.from_client = event.from_client;
  shown.time = event.time;
  modbus_.record(std::move(shown));
}

void ReplayTaps::show_page(const v1::JournalWire& wire, protocols::WireEvent event) {
  v1::ViewerRequest request;
  if (!event.from_client || !request.ParseFromString(wire.data())) return;
  event.source = "page";
  event.id = request.id();
  event.state = wire.text();
  event.type = web::title_of(request, *cell_.latest()->cell);
  event.data = web::json_of(request);
  if (request.has_conveyor() || request.has_write_register()) modbus_.record(event);
  crcl_.record(std::move(event));
}

}  // namespace aprsim::server
