#pragma once

#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"

/// A demonstration of robots and belt.
namespace aprsim::client {

struct DemoCommand {
  std::vector<std::string> robots;  ///< only these; empty = all, unless only the belt is wanted
  bool belt = false;                ///< only the belt, or the belt besides the named robots
};

[[nodiscard]] Outcome<void> run_command(const DemoCommand& command, Console& console);

/// Their words and options.
void add_demo(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
