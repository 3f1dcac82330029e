#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cell_connection.hpp"
#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/event_text.hpp"

namespace aprsim::client {
namespace {

nlohmann::ordered_json event_object(const v1::StreamEventsResponse& response) {
  using EventJson = nlohmann::ordered_json;
  const v1::CellEvent& event = response.event();
  return {{"sequence", event.sequence()},
          {"epoch", event.epoch()},
          {"step", event.step()},
          {"sim_time_s",
           static_cast<double>(event.sim_time().seconds()) + 1e-9 * event.sim_time().nanos()},
          {"kind", event_kind_word(event.kind())},
          {"names", std::vector<std::string>(event.names().begin(), event.names().end())},
          {"text", event.text()},
          {"robot", event.has_robot() ? EventJson(event.robot()) : EventJson()},
          {"number", event.number()},
          {"lost", response.lost()}};
}

}  // namespace

Outcome<void> run_command(const EventsCommand& command, Console& console) {
  v1::StreamEventsRequest request;
  if (command.after || command.past) request.set_after(command.after.value_or(0));
  request.set_past_only(command.past);
  request.set_allow_gap(true);  // which is shown
  for (const auto& word : command.kinds) {
    if (const auto kind = event_kind(word)) request.add_kinds(*kind);
  }
  for (const auto& name : command.names) request.add_names(name);
  std::uint64_t shown = 0;
  return CellConnection(console.endpoints).events(request, [&](const auto& response) {
    std::string text = event_line(response.event()) + "\n";
    if (response.lost() > 0) {
      text = fmt::format("({} events before it are not kept any more)\n{}", response.lost(), text);
    }
    console.show(text, event_object(response));
    return console.out.good() && ++shown != command.count;
  });
}

}  // namespace aprsim::client
