#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/trace/capture.hpp"
#include "clients/aprsim/trace/comparison.hpp"
#include "clients/aprsim/trace/comparison_report.hpp"
#include "clients/aprsim/trace/exports.hpp"
#include "clients/aprsim/trace/listing.hpp"
#include "clients/aprsim/trace/motion.hpp"
#include "clients/aprsim/trace/trace.hpp"
#include "clients/process/own_programs.hpp"

namespace aprsim::client {
namespace {

Failure wrong_trace(const Error& error) { return {FailureKind::kUsage, error.message}; }

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
    return failed(FailureKind::kUsage, place + " has recorded nothing of the wires");
  }
  const trace::Comparison comparison = trace::compare(*a, *b, tolerance);
  console.show(trace::report_text(comparison, command.most),
               trace::report_json(comparison, *a, *b, tolerance));
  if (comparison.same()) return {};
  return failed(FailureKind::kCheck, "the runs differ: " + comparison.deviations.front().text);
}

Outcome<void> run_command(const TraceExportCommand& command, Console& console) {
  // A capture has wires only.
  std::optional<bool> has_scene;
  if (const auto read = trace::for_each_record(command.place,
                                               [&](const v1::JournalRecord& record) {
                                                 if (record.has_header()) {
                                                   has_scene =
                                                       !record.header().scene_text().empty();
                                                 }
                                               });
      !read) {
    return tl::unexpected(wrong_trace(read.error()));
  }
  const auto motion = [&](double usual_hz) -> Outcome<std::optional<trace::Motion>> {
    if (!has_scene.value_or(false)) return std::optional<trace::Motion>();
    auto made = trace::Motion::of(command.place, {.rate_hz = command.rate_hz.value_or(usual_hz),
                                                  .from_s = command.from_s,
                                                  .to_s = command.to_s});
    if (!made) return tl::unexpected(made.error());
    return std::optional<trace::Motion>(std::move(*made));
  };
  const auto show = [&](const char* kind, const std::string& to,
                        const Outcome<trace::Exported>& done) -> Outcome<void> {
    if (!done) return tl::unexpected(done.error());
    console.show(fmt::format("{}: {} snapshots, {} of wires, {} events\n", to, done->snapshots,
                             done->wires, done->events),
                 {{"written", kind},
                  {"to", to},
                  {"snapshots", done->snapshots},
                  {"wires", done->wires},
                  {"events", done->events},
                  {"messages", done->messages}});
    return {};
  };
  constexpr double kUsual_hz = 50, kPage_hz = 20;
  if (!command.csv.empty() || !command.mcap.empty()) {
    const auto moved = motion(kUsual_hz);
    if (!moved) return tl::unexpected(moved.error());
    const std::string file = *moved ? (*moved)->file() : "";
    if (!command.csv.empty()) {
      const auto done = trace::export_csv(command.place, file, command.csv);
      if (auto shown = show("csv", command.csv, done); !shown) return shown;
    }
    if (!command.mcap.empty()) {
      const auto done = trace::export_mcap(command.place, file, command.mcap);
      if (auto shown = show("mcap", command.mcap, done); !shown) return shown;
    }
  }
  if (command.html.empty()) return {};
  const auto moved = motion(kPage_hz);
  if (!moved) return tl::unexpected(moved.error());
  return show("html", command.html,
              trace::export_html(command.place, *moved ? (*moved)->file() : "", command.html,
                                 process::web_directory()));
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
                      {"connections", imported->connections},
                      {"records", imported->records},
                      {"duration_s", imported->duration_s},
                      {"by_listener", imported->by_listener},
                      {"notes", imported->notes}});
  if (!imported->by_listener.empty()) return {};
  return failed(FailureKind::kCheck,
                "the capture has nothing of these listeners: see --port for where they are");
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

}  // namespace aprsim::client
