#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// Commands for recorded runs.
namespace aprsim::client {

struct TraceDiffCommand {
  std::string a, b;                          ///< files or directories of journals
  std::map<std::string, double> tolerances;  ///< by name (trace::tolerance_names())
  std::size_t most = 10;                     ///< number of worst deviations in the text
};
struct TraceImportCommand {
  std::string capture;                         ///< pcap or pcapng
  std::string out;                             ///< the journal to write
  std::map<std::uint16_t, std::string> ports;  ///< listeners by port; empty = the usual ones
};
struct TraceExportCommand {
  std::string place;                   ///< file or directory of journals
  std::string csv, mcap, html;         ///< directory and files to write; empty = not
  std::string camera;                  ///< whose video to write; empty = none
  std::string video_file;              ///< empty = the camera's name with .mp4
  std::optional<double> rate_hz;       ///< frames per second; absent = the default of the export
  std::optional<double> from_s, to_s;  ///< of the motion; simulated
};
struct TraceShowCommand {
  std::string place;  ///< file or directory of journals
  std::string wire;   ///< only this listener; empty = all
  bool polls = false;
  std::optional<double> from_s, to_s;  ///< simulated
};

[[nodiscard]] Outcome<void> run_command(const TraceDiffCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const TraceImportCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const TraceExportCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const TraceShowCommand& command, Console& console);

/// Their words and options.
void add_trace(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
