#include "server/journal/record_message.hpp"

#include <chrono>

#include "protocols/messages/enum_match.hpp"
#include "protocols/messages/write_message.hpp"
#include "server/journal/command_message.hpp"
#include "server/journal/digest.hpp"
#include "world/base/utf8.hpp"
#include "world/cell/state_bytes.hpp"

namespace aprsim::protocols {

template <>
struct EnumMatch<WireKind> : SameOrder<WireKind::kSimpleMessage, v1::WireKind_MAX> {};
template <>
struct EnumMatch<WireContent> : SameOrder<WireContent::kClosed, v1::WireContent_MAX> {};

}  // namespace aprsim::protocols

namespace aprsim::server::journal {
namespace {

void write_time(world::RunTime time, v1::JournalTime& message) {
  message.set_epoch(time.epoch);
  message.set_step(time.step);
}

void write(const EpochBegun& epoch, v1::JournalRecord& record) {
  auto& to = *record.mutable_epoch();
  write_time(epoch.time, *to.mutable_time());
  to.set_seed(epoch.seed);
  if (epoch.loaded) to.set_loaded_state(*epoch.loaded);
}

void write(const CommandApplied& applied, v1::JournalRecord& record) {
  auto& to = *record.mutable_command();
  write_message(applied.command.command, to);
  write_time(applied.time, *to.mutable_time());
  to.set_sequence(applied.sequence);
  to.set_ticket(applied.command.ticket);
  to.set_failure(applied.failure);
}

void write(const StateSampled& sampled, v1::JournalRecord& record) {
  auto& to = *record.mutable_state();
  write_time(sampled.time, *to.mutable_time());
  to.set_hash(sampled.sample.hash);
  for (const double angle : sampled.sample.joints_rad) to.add_joints_rad(angle);
  for (const double coordinate : sampled.sample.bodies_m) to.add_bodies_m(coordinate);
  to.set_belt_travel_m(sampled.sample.belt_travel_m);
}

void write(const StateSaved& saved, v1::JournalRecord& record) {
  auto& to = *record.mutable_checkpoint();
  write_time(saved.time, *to.mutable_time());
  to.set_state(world::to_bytes(*saved.state));
  to.set_state_sha256(sha256(to.state()));
  to.set_hash(saved.hash);
}

void write(const WorldStopped& stopped, v1::JournalRecord& record) {
  auto& to = *record.mutable_event();
  to.set_epoch(stopped.time.epoch);
  to.set_step(stopped.time.step);
  to.set_kind(v1::CELL_EVENT_KIND_WORLD_STOPPED);
  to.set_text(stopped.why);
}

void write(const api::CellEventPtr& event, v1::JournalRecord& record) {
  protocols::write_message(*event, *record.mutable_event());
}

void write(const Refused& refused, v1::JournalRecord& record) {
  api::CellEvent event;
  event.epoch = refused.time.epoch;
  event.step = refused.time.step;
  event.time = refused.sim_time;
  event.kind = api::CellEventKind::kRefused;
  event.names = {refused.listener};
  event.text = refused.what;
  protocols::write_message(event, *record.mutable_event());
}

void write(const protocols::WireRecord& wire, v1::JournalRecord& record) {
  auto& to = *record.mutable_wire();
  write_time(world::RunTime{wire.epoch, wire.step}, *to.mutable_time());
  protocols::write_message(wire.sim_time, *to.mutable_sim_time());
  to.set_kind(protocols::to_message(wire.connection->kind));
  to.set_listener(wire.connection->listener);
  to.set_connection(wire.connection->number);
  to.set_peer(wire.connection->peer);
  to.set_content(protocols::to_message(wire.content));
  to.set_data(wire.data);
  to.set_method(wire.method);
  to.set_text(wire.text);
}

}  // namespace

void write_time(WallTime time, google::protobuf::Timestamp& message) {
  const auto since = std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch());
  message.set_seconds(since.count() / 1'000'000'000);
  message.set_nanos(static_cast<std::int32_t>(since.count() % 1'000'000'000));
}

void write_message(const Entry& entry, v1::JournalRecord& record) {
  write_time(entry.wall, *record.mutable_wall_time());
  std::visit([&record](const auto& what) { write(what, record); }, entry.what);
}

void write_message(const Missing& missing, v1::JournalRecord& record) {
  write_time(std::chrono::system_clock::now(), *record.mutable_wall_time());
  auto& to = *record.mutable_gap();
  to.set_records(missing.records);
  to.set_commands(missing.commands);
  write_time(missing.begin, *to.mutable_begin());
  write_time(missing.end, *to.mutable_end());
  to.set_reason(utf8::valid(missing.reason));
}

}  // namespace aprsim::server::journal
