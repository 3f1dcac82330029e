#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"

/// Commands for scenarios.
namespace aprsim::client {

struct ScenarioListCommand {};
struct ScenarioCheckCommand {
  std::vector<std::string> files;  ///< or names
  std::uint64_t seed = 1;
};
struct ScenarioRunCommand {
  std::string name;  ///< or a file
  std::uint64_t seed = 1;
  std::optional<double> speed = 1;  ///< absent = as fast as possible
  std::string controller;           ///< empty = the kitting controller
  std::string report;               ///< directory; empty = none
  bool attach = false;              ///< run in the running cell instead of an own daemon
  bool progress = false;            ///< report progress as JSON lines
  bool virtual_time = false;        ///< the controller's polls advance the time
  std::string journal;              ///< file or directory of the own daemon; empty = none
  unsigned repeat = 0;        ///< runs in virtual time, from `seed` on, as a batch; 0 = one run
  unsigned jobs = 1;          ///< parallel runs
  unsigned patience_s = 600;  ///< of wall time without progress, in virtual time
};

[[nodiscard]] Outcome<void> run_command(const ScenarioListCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ScenarioCheckCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ScenarioRunCommand& command, Console& console);

/// Their words and options.
void add_scenario(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
