#include "clients/aprsim/commands/document_commands.hpp"

#include <ostream>

#include <CLI/CLI.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/completion.hpp"
#include "clients/aprsim/commands/manual.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"

namespace aprsim::client {

Outcome<void> run_command(const CompletionCommand& command, Console& console) {
  console.write(command.shell == "bash" ? bash_completion() : zsh_completion());
  return {};
}

Outcome<void> run_command(const ManualCommand& /*command*/, Console& console) {
  console.write(manual_page());
  return {};
}

void add_documents(CLI::App& app, CommandLine& line) {
  auto [completion, command] = add_command<CompletionCommand>(
      app, line, "completion", "Print the completion script for a shell");
  choose(completion->add_option("SHELL", command->shell, "bash or zsh")->required(),
         {"bash", "zsh"});
  add_command<ManualCommand>(app, line, "manual", "Print the manual page, for man -l -");
}

}  // namespace aprsim::client
