#include "clients/aprsim/trace/action.hpp"

#include <set>

namespace aprsim::trace {
namespace {

/// Events that characterise a run. Contacts and simplification depend on the last bits of a pose
/// and are left out.
const std::set<v1::CellEventKind> kTelling = {
    v1::CELL_EVENT_KIND_GRASPED,       v1::CELL_EVENT_KIND_RELEASED,
    v1::CELL_EVENT_KIND_LOST,          v1::CELL_EVENT_KIND_PROTECTIVE_STOP,
    v1::CELL_EVENT_KIND_FAULT_BEGUN,   v1::CELL_EVENT_KIND_FAULT_ENDED,
    v1::CELL_EVENT_KIND_WORLD_STOPPED, v1::CELL_EVENT_KIND_DRIVE_TRIPPED};

}  // namespace

void add_pauses(std::vector<Action>& actions) {
  for (std::size_t i = 1; i < actions.size(); ++i) {
    const Action& before = actions[i - 1];
    const double ended_s = before.time_s + before.duration_s.value_or(0);
    actions[i].pause_s =
        actions[i].time_s - (ended_s <= actions[i].time_s ? ended_s : before.time_s);
  }
}

std::map<std::string, WireActions> actions_of(const Trace& trace) {
  std::map<std::string, Records> listeners;
  for (const WireRecord& record : trace.wires) {
    listeners[record.wire.listener()].push_back(&record);
  }
  std::map<std::string, WireActions> out;
  for (const auto& [name, records] : listeners) {
    const v1::WireKind kind = records.front()->wire.kind();
    WireActions wire = kind == v1::WIRE_KIND_CRCL             ? crcl_actions(records)
                       : kind == v1::WIRE_KIND_MODBUS         ? modbus_actions(records)
                       : kind == v1::WIRE_KIND_VISION         ? vision_actions(records)
                       : kind == v1::WIRE_KIND_SIMPLE_MESSAGE ? simple_message_actions(records)
                                                              : call_actions(records);
    wire.name = name;
    wire.kind = kind;
    add_pauses(wire.actions);
    out.emplace(name, std::move(wire));
  }
  // Events of one robot keep their order; between robots timing decides.
  for (const EventRecord& record : trace.events) {
    const v1::CellEvent& event = record.event;
    if (!kTelling.contains(event.kind())) continue;
    const std::string name =
        event.has_robot() ? "events.robot_" + std::to_string(event.robot() + 1) : "events";
    WireActions& wire = out[name];
    wire.name = name;
    Action action{.kind = event_word(event.kind()), .time_s = record.time_s};
    for (int i = 0; i < event.names_size(); ++i) {
      action.fields.push_back({i == 0 ? "subject" : "object", event.names(i)});
    }
    wire.actions.push_back(std::move(action));
  }
  return out;
}

}  // namespace aprsim::trace
