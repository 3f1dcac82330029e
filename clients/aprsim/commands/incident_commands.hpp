#pragma once

#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// The latest of the run as a file.
namespace aprsim::client {

struct IncidentCommand {
  double last_s = 60;  ///< simulated
  std::string file;    ///< empty = by the name that the daemon gives it, here
};

[[nodiscard]] Outcome<void> run_command(const IncidentCommand& command, Console& console);

/// Their words and options.
void add_incident(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
