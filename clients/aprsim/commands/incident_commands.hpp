#pragma once

#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// Writes the latest part of the run to a file.
namespace aprsim::client {

struct IncidentCommand {
  double last_s = 60;  ///< simulated
  std::string file;    ///< empty = the daemon's name for it, in this directory
};

[[nodiscard]] Outcome<void> run_command(const IncidentCommand& command, Console& console);

/// Their words and options.
void add_incident(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
