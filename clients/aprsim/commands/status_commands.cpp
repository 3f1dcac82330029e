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

Outcome<std::string> json_text(const google::protobuf::Message& message, bool pretty) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = pretty;
  options.always_print_primitive_fields = true;
  options.preserve_proto_field_names = true;
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(message, &text, options);
  if (!status.ok()) return failed(FailureKind::kCheck, "no JSON form: " + status.ToString());
  return text;
}

// The exit code tells scripts and containers that watch the cell's health.
Outcome<void> healthy(const v1::GetSnapshotResponse& status) {
  if (status.problem().empty()) return {};
  return failed(FailureKind::kCheck, status.problem());
}

}  // namespace

Outcome<void> run_command(const StatusCommand& command, Console& console) {
  const auto status = CellConnection(console.endpoints).status();
  if (!status) return tl::unexpected(status.error());
  if (console.json) {
    const auto text = json_text(status->snapshot(), true);
    if (!text) return tl::unexpected(text.error());
    console.out << *text;
    return healthy(*status);
  }
  console.out << status_text(status->snapshot(), console.screen.out);
  if (command.bodies) console.out << bodies_text(status->snapshot());
  return healthy(*status);
}

Outcome<void> run_command(const WatchCommand& command, Console& console) {
  const Paint& paint = console.screen.out;
  const bool in_place = console.screen.live && !console.json;
  LiveView view(console.out);
  std::uint64_t shown = 0;
  Outcome<void> shown_well;
  const auto streamed =
      CellConnection(console.endpoints).stream(command.rate_hz, [&](const auto& sample) {
        if (console.json) {
          const auto text = json_text(sample, false);
          if (!text) {
            shown_well = tl::unexpected(text.error());
            return false;
          }
          console.out << *text << '\n';
        } else if (in_place) {
          view.show(status_text(sample.snapshot(), paint) + dropped_text(sample.dropped_count()));
        } else {
          console.out << watch_line(sample.snapshot(), sample.dropped_count(), paint);
        }
        console.out.flush();
        return console.out.good() && ++shown != command.count;
      });
  return shown_well ? streamed : shown_well;
}

void add_status(CLI::App& app, CommandLine& line) {
  auto [status, status_command] =
      add_command<StatusCommand>(app, line, "status", "Show the cell as it is now");
  offer_json(*status, line, "The whole snapshot as JSON");
  status->add_flag("--bodies", status_command->bodies, "Also a line for each gear and tray");
  auto [watch, watch_command] = add_command<WatchCommand>(
      app, line, "watch",
      "Show the cell until interrupted: in place on a terminal, else one line a sample");
  watch->add_option("--rate", watch_command->rate_hz, "Samples a second (default 20)")
      ->type_name("HZ")
      ->check(above_zero());
  watch->add_option("--count", watch_command->count, "End after so many samples")->type_name("N");
  offer_json(*watch, line);
}

}  // namespace aprsim::client
