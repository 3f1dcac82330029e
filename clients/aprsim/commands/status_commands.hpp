#pragma once

#include <cstdint>

#include "clients/aprsim/commands/command_group.hpp"

/// Commands that show the state of the cell.
namespace aprsim::client {

struct StatusCommand {
  bool bodies = false;  ///< also one line for each gear and tray
};
struct WatchCommand {
  double rate_hz = 0;       ///< 0 = the daemon's default
  std::uint64_t count = 0;  ///< samples to show; 0 = until interrupted
};

[[nodiscard]] Outcome<void> run_command(const StatusCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const WatchCommand& command, Console& console);

/// Their words and options.
void add_status(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
