#include "clients/aprsim/commands/trace_commands.hpp"

#include <algorithm>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/trace/capture.hpp"
#include "clients/aprsim/trace/comparison.hpp"
#include "clients/aprsim/trace/comparison_report.hpp"
#include "clients/aprsim/trace/exports.hpp"
#include "clients/aprsim/trace/listing.hpp"
#include "clients/aprsim/trace/motion.hpp"
#include "clients/aprsim/trace/trace.hpp"
#include "clients/aprsim/trace/values.hpp"
#include "world/base/process/own_programs.hpp"

namespace aprsim::client {
namespace {

Failure wrong_trace(const Error& error) { return {FailureKind::kUsage, error.message}; }

void set_tolerance(TraceDiffCommand& command, const std::string& text) {
  const auto [name, value] = named_number_of(text);
  const auto& names = trace::tolerance_names();
  if (!value || *value < 0 ||
      std::ranges::find(names, name, &trace::ToleranceName::name) == names.end()) {
    std::string all;
    for (const auto& one : names) all += (all.empty() ? "" : ", ") + std::string(one.name);
    throw CLI::ValidationError(
        "--tolerance", "'" + text + "' is not NAME=NUMBER, from 0 up, with a name of " + all);
  }
  command.tolerances[name] = *value;
}

void set_listener_port(TraceImportCommand& command, const std::string& text) {
  const auto [name, number] = named_number_of(text);
  const auto port = port_of(number);
  if (!trace::is_listener_name(name) || !port) {
    throw CLI::ValidationError(
        "--port", "'" + text +
                      "' is not LISTENER=PORT with modbus, or crcl., vision., motion., state. or "
                      "gripper.NAME");
  }
  command.ports[*port] = name;
}

void add_trace_import(CLI::App& trace, CommandLine& line) {
  auto [sub, command] = add_command<TraceImportCommand>(
      trace, line, "import", "Convert a network capture, as of a real laboratory, to a journal");
  sub->add_option("FILE", command->capture, "Capture file of tcpdump or Wireshark (pcap, pcapng)")
      ->required();
  sub->add_option("--out", command->out, "Journal to write")
      ->type_name("JOURNAL")
      ->check(not_empty())
      ->required();
  sub->add_option_function<std::vector<std::string>>(
         "--port",
         [c = command](const std::vector<std::string>& all) {
           for (const auto& one : all) set_listener_port(*c, one);
         },
         "Port of a listener: modbus, or crcl., vision., motion., state. or gripper.NAME (default: "
         "crcl.fanuc=64444, crcl.motoman=64445, modbus=502 and 1502, vision.fanuc=4000, "
         "vision.motoman=4001, motion, state and gripper.fanuc=11000, 11002, 12123, those of the "
         "motoman=50240, 50241, 50242)")
      ->type_name("LISTENER=PORT")
      ->allow_extra_args(false);
  offer_json(*sub, line);
}

void add_trace_show(CLI::App& trace, CommandLine& line) {
  auto [show, command] =
      add_command<TraceShowCommand>(trace, line, "show", "List the messages and events of a run");
  show->add_option("FILE", command->place,
                   "Journal of a run: a file, or a directory with its files")
      ->required();
  show->add_option("--wire", command->wire,
                   "List only this listener, such as crcl.fanuc, modbus or cell")
      ->type_name("LISTENER")
      ->check(not_empty());
  show->add_flag("--polls", command->polls, "Include polls, replies and vision lines");
  show->add_option("--from", command->from_s, "List from this simulated time on")
      ->type_name("SECONDS")
      ->check(finite());
  show->add_option("--to", command->to_s, "List until this simulated time")
      ->type_name("SECONDS")
      ->check(finite());
  offer_json(*show, line);
}

void add_trace_export(CLI::App& trace, CommandLine& line) {
  auto [sub, command] = add_command<TraceExportCommand>(
      trace, line, "export",
      "Export a run: CSV tables, an MCAP file, a page that needs no daemon, or a camera's video");
  sub->add_option("FILE", command->place, "Journal of a run: a file, or a directory with its files")
      ->required();
  CLI::Option* csv = sub->add_option("--csv", command->csv,
                                     "Directory for CSV tables of joints, bodies, belt, events, "
                                     "wires")
                         ->type_name("DIR")
                         ->check(not_empty());
  CLI::Option* mcap = sub->add_option("--mcap", command->mcap, "MCAP file with Foxglove schemas")
                          ->type_name("FILE")
                          ->check(not_empty());
  CLI::Option* html =
      sub->add_option("--html", command->html, "HTML page that shows the run offline")
          ->type_name("FILE")
          ->check(not_empty());
  CLI::Option* video =
      sub->add_option("--video", command->camera,
                      "Render what this camera of the scene saw, as MP4; needs ffmpeg")
          ->type_name("CAMERA")
          ->check(not_empty());
  sub->add_option("--video-file", command->video_file, "File of the video (default CAMERA.mp4)")
      ->type_name("FILE")
      ->check(not_empty())
      ->needs(video);
  sub->callback([&line, csv, mcap, html, video, c = command] {
    if (csv->empty() && mcap->empty() && html->empty() && video->empty()) {
      throw CLI::RequiredError("--csv, --mcap, --html or --video");
    }
    line.command = *c;
  });
  constexpr double kMaxRate = 1000;
  sub->add_option(
         "--rate", command->rate_hz,
         "Frames per second of simulated time (default 50; 20 with --html, 25 with --video)")
      ->type_name("HZ")
      ->check(above_zero(kMaxRate));
  sub->add_option("--from", command->from_s, "Export motion from this simulated time on")
      ->type_name("SECONDS")
      ->check(within(0, 1e9));
  sub->add_option("--to", command->to_s, "Export motion until this simulated time")
      ->type_name("SECONDS")
      ->check(within(0, 1e9));
  offer_json(*sub, line, "Print one JSON object for each file written");
}

}  // namespace

Outcome<void> run_command(const TraceDiffCommand& command, Console& console) {
  trace::Tolerance tolerance;
  for (const trace::ToleranceName& name : trace::tolerance_names()) {
    const auto given = command.tolerances.find(name.name);
    if (given != command.tolerances.end()) tolerance.*name.place = given->second;
  }
  const auto a = trace::read_trace(command.a);
  if (!a) return tl::unexpected(wrong_trace(a.error()));
  const auto b = trace::read_trace(command.b);
  if (!b) return tl::unexpected(wrong_trace(b.error()));
  for (const auto& [place, one] : {std::pair(command.a, &*a), std::pair(command.b, &*b)}) {
    if (!one->wires.empty()) continue;
    return failed(FailureKind::kUsage, place + " contains no traffic");
  }
  const trace::Comparison comparison = trace::compare(*a, *b, tolerance);
  console.show(trace::report_text(comparison, command.most),
               trace::report_json(comparison, *a, *b, tolerance));
  if (comparison.same()) return {};
  return failed(FailureKind::kCheck, "the runs differ: " + comparison.deviations.front().text);
}

namespace {

/// The file of the video; empty = none.
std::string video_of(const TraceExportCommand& command) {
  if (command.camera.empty() || !command.video_file.empty()) return command.video_file;
  return command.camera + ".mp4";
}

/// All files that an export writes.
std::vector<std::string> outputs_of(const TraceExportCommand& command) {
  std::vector<std::string> out;
  if (!command.csv.empty()) out = trace::csv_files(command.csv);
  for (const std::string& file : {command.mcap, command.html, video_of(command)}) {
    if (!file.empty()) out.push_back(file);
  }
  return out;
}

/// Whether a run has a scene: a capture has wires only.
Outcome<bool> has_scene(const std::string& place) {
  std::optional<bool> found;
  const auto read = trace::for_each_record(place, [&](const v1::JournalRecord& record) {
    if (record.has_header()) found = !record.header().scene_text().empty();
  });
  if (!read) return tl::unexpected(wrong_trace(read.error()));
  return found.value_or(false);
}

/// The exports of one command, each of which shows what it wrote.
class Exports {
 public:
  Exports(const TraceExportCommand& command, Console& console, bool has_scene)
      : command_(command), console_(console), has_scene_(has_scene) {}

  [[nodiscard]] Outcome<void> write_tables() {
    constexpr double kUsual_hz = 50;
    const auto motion = motion_at(kUsual_hz);
    if (!motion) return tl::unexpected(motion.error());
    const std::string file = *motion ? (*motion)->file() : "";
    if (!command_.csv.empty()) {
      const auto done = trace::export_csv(command_.place, file, command_.csv);
      if (auto shown = show("csv", command_.csv, done); !shown) return shown;
    }
    if (command_.mcap.empty()) return {};
    return show("mcap", command_.mcap, trace::export_mcap(command_.place, file, command_.mcap));
  }

  [[nodiscard]] Outcome<void> write_video() {
    constexpr double kUsual_hz = 25;
    if (!has_scene_) {
      return failed(FailureKind::kUsage,
                    command_.place + " has no scene whose camera could see it");
    }
    const trace::VideoChoice choice{.camera = command_.camera,
                                    .rate_hz = command_.rate_hz.value_or(kUsual_hz),
                                    .from_s = command_.from_s,
                                    .to_s = command_.to_s};
    const std::string file = video_of(command_);
    const auto done = trace::export_video(command_.place, choice, file);
    if (!done) return tl::unexpected(done.error());
    console_.show(fmt::format("{}: {} pictures\n", file, done->snapshots),
                  {{"written", "video"}, {"to", file}, {"pictures", done->snapshots}});
    return {};
  }

  [[nodiscard]] Outcome<void> write_page() {
    constexpr double kUsual_hz = 20;
    const auto motion = motion_at(kUsual_hz);
    if (!motion) return tl::unexpected(motion.error());
    return show("html", command_.html,
                trace::export_html(command_.place, *motion ? (*motion)->file() : "", command_.html,
                                   process::web_directory()));
  }

 private:
  /// Absent for a run without a scene.
  [[nodiscard]] Outcome<std::optional<trace::Motion>> motion_at(double usual_hz) const {
    if (!has_scene_) return std::optional<trace::Motion>();
    auto made = trace::Motion::of(command_.place, {.rate_hz = command_.rate_hz.value_or(usual_hz),
                                                   .from_s = command_.from_s,
                                                   .to_s = command_.to_s});
    if (!made) return tl::unexpected(made.error());
    return std::optional<trace::Motion>(std::move(*made));
  }

  Outcome<void> show(const char* kind, const std::string& to,
                     const Outcome<trace::Exported>& done) {
    if (!done) return tl::unexpected(done.error());
    console_.show(fmt::format("{}: {} snapshots, {} of wires, {} events\n", to, done->snapshots,
                              done->wires, done->events),
                  {{"written", kind},
                   {"to", to},
                   {"snapshots", done->snapshots},
                   {"wires", done->wires},
                   {"events", done->events},
                   {"messages", done->messages}});
    return {};
  }

  const TraceExportCommand& command_;
  Console& console_;
  const bool has_scene_;
};

}  // namespace

Outcome<void> run_command(const TraceExportCommand& command, Console& console) {
  if (auto apart = trace::check_exports(command.place, outputs_of(command)); !apart) return apart;
  const auto scene = has_scene(command.place);
  if (!scene) return tl::unexpected(scene.error());
  Exports exports(command, console, *scene);
  if (!command.csv.empty() || !command.mcap.empty()) {
    if (auto done = exports.write_tables(); !done) return done;
  }
  if (!command.camera.empty()) {
    if (auto done = exports.write_video(); !done) return done;
  }
  return command.html.empty() ? Outcome<void>() : exports.write_page();
}

Outcome<void> run_command(const TraceImportCommand& command, Console& console) {
  const auto imported = trace::import_capture(
      command.capture, command.out, command.ports.empty() ? trace::usual_ports() : command.ports);
  if (!imported) return tl::unexpected(wrong_trace(imported.error()));
  std::string text = fmt::format("{}: {} records of {} connections, {} packets, {:.3f} s\n",
                                 command.out, imported->records, imported->connections,
                                 imported->packets, imported->duration_s);
  for (const auto& [listener, count] : imported->by_listener) {
    text += fmt::format("  {:<20} {}\n", listener, count);
  }
  for (const std::string& note : imported->notes) text += "note: " + note + '\n';
  console.show(text, {{"journal", command.out},
                      {"packets", imported->packets},
                      {"skipped", imported->skipped},
                      {"connections", imported->connections},
                      {"records", imported->records},
                      {"duration_s", imported->duration_s},
                      {"by_listener", imported->by_listener},
                      {"notes", imported->notes}});
  if (!imported->by_listener.empty()) return {};
  return failed(FailureKind::kCheck,
                imported->skipped > 0
                    ? "no traffic of these listeners in the packets that can be read; see the notes"
                    : "the capture has no traffic of these listeners; set their ports with --port");
}

Outcome<void> run_command(const TraceShowCommand& command, Console& console) {
  const auto notes = trace::list_trace(command.place,
                                       {.wire = command.wire,
                                        .polls = command.polls,
                                        .from_s = command.from_s,
                                        .to_s = command.to_s},
                                       [&](const trace::ListedLine& line) {
                                         console.show(trace::text_of(line), trace::json_of(line));
                                       });
  if (!notes) return tl::unexpected(wrong_trace(notes.error()));
  if (notes->empty()) return {};
  std::string text;
  for (const std::string& note : *notes) text += "note: " + note + '\n';
  console.show(text, {{"notes", *notes}});
  return {};
}

void add_trace(CLI::App& app, CommandLine& line) {
  CLI::App* trace = app.add_subcommand("trace", "List, compare, import and export recorded runs");
  trace->require_subcommand(1);
  auto [diff, command] = add_command<TraceDiffCommand>(
      *trace, line, "diff",
      "Compare two runs of a controller by robot and wire, ignoring polls and ids");
  diff->add_option("A", command->a, "Journal of a run: a file, or a directory with its files")
      ->required();
  diff->add_option("B", command->b, "Journal of the run to compare")->required();
  std::string help = "Tolerances:";
  const trace::Tolerance defaults;
  for (const auto& one : trace::tolerance_names()) {
    help += std::string(one.name == trace::tolerance_names().front().name ? " " : "; ") + one.name +
            " (" + CLI::detail::to_string(defaults.*one.place) + "), " + one.meaning;
  }
  diff->add_option_function<std::vector<std::string>>(
          "--tolerance",
          [c = command](const std::vector<std::string>& all) {
            for (const auto& one : all) set_tolerance(*c, one);
          },
          help)
      ->type_name("NAME=NUMBER")
      ->allow_extra_args(false);
  diff->add_option("--worst", command->most, "Show the N worst deviations (default 10)")
      ->type_name("N");
  offer_json(*diff, line, "Print the comparison as one JSON object");
  add_trace_export(*trace, line);
  add_trace_import(*trace, line);
  add_trace_show(*trace, line);
}

}  // namespace aprsim::client
