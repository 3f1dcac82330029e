#include "protocols/web/topics/topic_message.hpp"

#include <chrono>

#include "protocols/messages/write_message.hpp"

namespace aprsim::web {
namespace {

double seconds(std::chrono::system_clock::time_point time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}

v1::FaultSeverity severity_of(FaultSeverity severity) {
  switch (severity) {
    case FaultSeverity::kNote:
      return v1::FAULT_SEVERITY_NOTE;
    case FaultSeverity::kWarning:
      return v1::FAULT_SEVERITY_WARNING;
    case FaultSeverity::kError:
      return v1::FAULT_SEVERITY_ERROR;
    case FaultSeverity::kStop:
      break;
  }
  return v1::FAULT_SEVERITY_STOP;
}

void write_time(const FaultTime& time, v1::FaultTime& out) {
  out.set_epoch(time.epoch);
  out.set_sim_time_s(time.sim_time_s);
  out.set_time_s(seconds(time.wall));
}

}  // namespace

void write_without_names(const api::Snapshot& snapshot, const std::string& instance_id,
                         v1::Snapshot& out) {
  protocols::write_message(snapshot, instance_id, out);
  for (auto& body : *out.mutable_bodies()) {
    body.clear_name();
    body.clear_type();
  }
}

void write_message(const protocols::WireEvent& event, v1::WireEvent& out) {
  out.set_source(event.source);
  out.set_peer(event.peer);
  out.set_from_client(event.from_client);
  out.set_time_s(seconds(event.time));
  out.set_type(event.type);
  out.set_id(event.id);
  out.set_state(event.state);
  out.set_latency_s(event.latency_s);
  out.set_data(event.data);
  out.set_data_bytes(event.data_bytes);
  out.set_sim_time_s(event.sim_time_s);
  out.set_epoch(event.sim_epoch);
  out.set_poll(event.poll);
  out.set_number(event.number);
}

void write_message(const FaultLog& log, v1::FaultList& out) {
  for (const Fault& fault : log.faults()) {
    auto& entry = *out.add_faults();
    entry.set_id(fault.id);
    entry.set_severity(severity_of(fault.severity));
    entry.set_source(fault.source);
    entry.set_message(fault.message);
    entry.set_count(fault.count);
    write_time(fault.first, *entry.mutable_first());
    write_time(fault.last, *entry.mutable_last());
    entry.set_active(fault.active);
  }
  out.set_discarded(log.discarded());
}

void write_message(const ProgramStatus& status, v1::ProgramStatus& out) {
  for (const ProgramOffer& offer : status.offers) {
    auto& entry = *out.add_offers();
    entry.set_name(offer.name);
    entry.set_description(offer.description);
    entry.set_scenario(offer.scenario);
  }
  out.set_refusal(status.refusal);
  out.set_name(status.name);
  out.set_running(status.running);
  out.set_stopping(status.stopping);
  out.set_failed(status.failed);
  out.set_end_reason(status.end_reason);
  out.set_time_s(status.time_s);
  out.set_placed(status.placed);
  for (const OrderProgress& order : status.orders) {
    auto& entry = *out.add_orders();
    entry.set_name(order.name);
    entry.set_tray(order.tray);
    entry.set_state(order.state);
    entry.set_kits(order.kits);
    entry.set_done(order.done);
    entry.set_parts(order.parts);
    entry.set_parts_wanted(order.parts_wanted);
  }
  for (const std::string& line : status.lines) out.add_lines(line);
  out.set_report(status.report);
}

}  // namespace aprsim::web
