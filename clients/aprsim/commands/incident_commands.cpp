#include "clients/aprsim/commands/incident_commands.hpp"

#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/wires/cell_connection.hpp"
#include "world/base/files/draft_file.hpp"

namespace aprsim::client {
namespace {

/// The daemon's name for the file, without directories.
std::string plain_name(const std::string& name) {
  const std::string plain = std::filesystem::path(name).filename().string();
  return plain.empty() || plain == "." || plain == ".." ? "incident.journal" : plain;
}

/// A name that nobody has chosen replaces no file.
Outcome<void> check_unused(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return {};
  return failed(FailureKind::kUsage, file + ": exists already; name another file by --file");
}

/// "60", "60s" or "2min" in seconds.
double span_of(const std::string& text) {
  constexpr double kLongest_s = 86'400;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  const double span_s = unit == "min" ? 60 * value : value;
  if (error != std::errc() || !(unit.empty() || unit == "s" || unit == "min") ||
      !(span_s > 0 && span_s <= kLongest_s)) {
    throw CLI::ValidationError(
        "--last", text + " is not a time above 0 and up to a day, such as 60s or 10min");
  }
  return span_s;
}

}  // namespace

Outcome<void> run_command(const IncidentCommand& command, Console& console) {
  std::string name = command.file;
  std::optional<files::DraftFile> file;
  std::uint64_t bytes = 0, expected = 0;
  Outcome<void> unused;
  const auto write = [&](const v1::GetIncidentResponse& piece) {
    if (!file) {
      if (name.empty()) {
        name = plain_name(piece.name());
        unused = check_unused(name);
        if (!unused) return false;
      }
      expected = piece.size();
      file.emplace(name);
    }
    file->out().write(piece.data().data(), static_cast<std::streamsize>(piece.data().size()));
    bytes += piece.data().size();
    return file->out().good();
  };
  const auto done = CellConnection(console.endpoints).incident(command.last_s, write);
  if (!unused) return unused;
  if (!done) return tl::unexpected(done.error());
  if (!file) return failed(FailureKind::kConnection, "the daemon sent no incident");
  if (file->out().good() && bytes != expected) {
    return failed(FailureKind::kConnection,
                  fmt::format("{}: only {} of {} bytes arrived", name, bytes, expected));
  }
  if (auto written = file->commit(); !written) {
    return failed(FailureKind::kUsage, written.error().message);
  }
  console.show(fmt::format("{}: {:.1f} MB\n", name, static_cast<double>(bytes) * 1e-6),
               {{"done", "incident"}, {"file", name}, {"bytes", bytes}});
  return {};
}

void add_incident(CLI::App& app, CommandLine& line) {
  auto [incident, command] = add_command<IncidentCommand>(
      app, line, "incident", "Write the latest part of the run to a journal that can be replayed");
  incident
      ->add_option_function<std::string>(
          "--last", [c = command](const std::string& text) { c->last_s = span_of(text); },
          "Simulated time to include, such as 60s or 10min (default 60s)")
      ->type_name("TIME");
  incident
      ->add_option("--file", command->file,
                   "File to write (default: the daemon's name for it, in this directory)")
      ->type_name("FILE")
      ->check(not_empty());
  offer_json(*incident, line);
}

}  // namespace aprsim::client
