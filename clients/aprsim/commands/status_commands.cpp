#include "clients/aprsim/commands/status_commands.hpp"

#include <ostream>

#include <CLI/CLI.hpp>
#include <google/protobuf/util/json_util.h>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/live_view.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/text/status_text.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {
namespace {

/// The message as JSON on one line.
Outcome<std::string> message_line(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  options.preserve_proto_field_names = true;
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(message, &text, options);
  if (!status.ok()) return failed(FailureKind::kCheck, "no JSON form: " + status.ToString());
  return text + '\n';
}

// The exit code tells scripts and containers that watch the cell's health.
Outcome<void> healthy(const v1::GetSnapshotResponse& status) {
  if (status.problem().empty()) return {};
  return failed(FailureKind::kCheck, status.problem());
}

}  // namespace

Outcome<void> run_command(const StatusCommand& command, Console& console) {
  CellConnection connection(console.endpoints);
  const auto status = connection.status();
  if (!status) return tl::unexpected(status.error());
  if (console.json) {
    const auto line = message_line(status->snapshot());
    if (!line) return tl::unexpected(line.error());
    console.print(*line);
    return healthy(*status);
  }
  const auto cell = connection.cell();
  if (!cell) return tl::unexpected(cell.error());
  console.print(status_text(status->snapshot(), *cell, console.screen.out));
  if (command.bodies) console.print(bodies_text(status->snapshot()));
  return healthy(*status);
}

Outcome<void> run_command(const WatchCommand& command, Console& console) {
  const Paint& paint = console.screen.out;
  const bool in_place = console.screen.live && !console.json;
  LiveView view(console.out);
  std::uint64_t shown = 0;
  Outcome<void> shown_well;
  CellConnection connection(console.endpoints);
  const auto cell = connection.cell();
  if (!cell) return tl::unexpected(cell.error());
  const auto streamed = connection.stream(command.rate_hz, [&](const auto& sample) {
    if (console.json) {
      const auto line = message_line(sample);
      if (!line) {
        shown_well = tl::unexpected(line.error());
        return false;
      }
      console.print(*line);
    } else if (in_place) {
      view.show(console.escaped(status_text(sample.snapshot(), *cell, paint) +
                                dropped_text(sample.dropped_count())));
      console.out.flush();
    } else {
      console.print(watch_line(sample.snapshot(), sample.dropped_count(), paint));
    }
    return console.out.good() && ++shown != command.count;
  });
  return shown_well ? streamed : shown_well;
}

void add_status(CLI::App& app, CommandLine& line) {
  auto [status, status_command] =
      add_command<StatusCommand>(app, line, "status", "Show the state of the cell");
  offer_json(*status, line, "Print the whole snapshot as one JSON object");
  status->add_flag("--bodies", status_command->bodies, "Also show a line for each gear and tray");
  auto [watch, watch_command] = add_command<WatchCommand>(
      app, line, "watch",
      "Show the cell until interrupted: in place on a terminal, else one line per sample");
  watch->add_option("--rate", watch_command->rate_hz, "Samples per second (default 20)")
      ->type_name("HZ")
      ->check(above_zero());
  watch->add_option("--count", watch_command->count, "Exit after N samples")->type_name("N");
  offer_json(*watch, line);
}

}  // namespace aprsim::client
