#pragma once

#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// Saved states of the cell.
namespace aprsim::client {

struct SaveCommand {
  std::string name;
  std::string file;  ///< file to write as well; empty = none
};
struct LoadCommand {
  std::string name;  ///< empty with a file = its saved name
  std::string file;  ///< file of the state; empty = the daemon has it
};
struct StatesListCommand {};
struct StatesDeleteCommand {
  std::string name;
};

[[nodiscard]] Outcome<void> run_command(const SaveCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const LoadCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const StatesListCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const StatesDeleteCommand& command, Console& console);

/// Their words and options.
void add_states(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
