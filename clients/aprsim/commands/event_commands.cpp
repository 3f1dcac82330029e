#include "clients/aprsim/commands/event_commands.hpp"

#include <ostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/text/event_text.hpp"
#include "clients/wires/cell_connection.hpp"

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
      text = fmt::format("({} earlier events have expired)\n{}", response.lost(), text);
    }
    console.show(text, event_object(response));
    return console.out.good() && ++shown != command.count;
  });
}

void add_events(CLI::App& app, CommandLine& line) {
  auto [events, command] = add_command<EventsCommand>(
      app, line, "events", "Show events of the cell, one per line, until interrupted");
  events
      ->add_option("--after", command->after,
                   "Start after event N of the stored ones (0: with the oldest)")
      ->type_name("NUMBER");
  events->add_flag("--past", command->past, "Show the stored events, then exit");
  choose(events->add_option("--kind", command->kinds, "Show only events of this kind; repeatable")
             ->allow_extra_args(false),
         event_kind_words());
  events
      ->add_option("--name", command->names,
                   "Show only events that involve this subject; repeatable")
      ->type_name("NAME")
      ->check(not_empty())
      ->allow_extra_args(false);
  events->add_option("--count", command->count, "Exit after N events")->type_name("N");
  offer_json(*events, line);
}

}  // namespace aprsim::client
