#pragma once

#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// Documents about the program itself.
namespace aprsim::client {

/// Prints a shell's completion of this command line.
struct CompletionCommand {
  std::string shell;  ///< bash or zsh
};
/// Prints the manual page.
struct ManualCommand {};

[[nodiscard]] Outcome<void> run_command(const CompletionCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ManualCommand& command, Console& console);

/// Their words and options.
void add_documents(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
