#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"

/// What happens in the cell.
namespace aprsim::client {

struct EventsCommand {
  std::optional<std::uint64_t> after;  ///< number; absent = from now on, or all that are kept
  bool past = false;                   ///< end after the latest
  std::vector<std::string> kinds;      ///< words (event_text.hpp); empty = all
  std::vector<std::string> names;      ///< of what takes part; empty = all
  std::uint64_t count = 0;             ///< events to show; 0 = until interrupted
};

[[nodiscard]] Outcome<void> run_command(const EventsCommand& command, Console& console);

/// Their words and options.
void add_events(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
