#pragma once

#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"

/// Replays of recorded runs.
namespace aprsim::client {

/// Replays a recorded run with aprsimd, as clients contain no simulation.
struct ReplayCommand {
  std::vector<std::string> files;  ///< of one run, in their order
  std::string from, to;            ///< SECONDS or EPOCH:SECONDS; empty = whole
  std::string speed;               ///< a factor or max; empty = the daemon's choice
  bool serve = false;              ///< to browsers and gRPC clients
  bool any_port = false;
  std::string ports_file;
};

[[nodiscard]] Outcome<void> run_command(const ReplayCommand& command, Console& console);

/// Their words and options.
void add_replay(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
