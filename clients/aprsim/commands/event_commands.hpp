#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"

/// Events of the cell.
namespace aprsim::client {

struct EventsCommand {
  std::optional<std::uint64_t> after;  ///< number; absent = from now on, or all stored ones
  bool past = false;                   ///< stored events only, then exit
  std::vector<std::string> kinds;      ///< words (event_text.hpp); empty = all
  std::vector<std::string> names;      ///< of subjects; empty = all
  std::uint64_t count = 0;             ///< events to show; 0 = until interrupted
};

[[nodiscard]] Outcome<void> run_command(const EventsCommand& command, Console& console);

/// Their words and options.
void add_events(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
