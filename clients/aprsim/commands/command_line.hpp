#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "clients/aprsim/commands/commands.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::client {

struct CommandLine {
  EndpointChoice endpoints;
  bool json = false;               ///< results as JSON
  bool exit_on_stdin_eof = false;  ///< stop when standard input ends
  AnyCommand command;
};

/// Text instead of a command: help (exit code 0, standard output) or an error with a suggestion
/// (exit code 2, standard error).
struct NoCommand {
  int exit_code = 2;
  std::string text;
};

/// `arguments` without the program's name.
[[nodiscard]] tl::expected<CommandLine, NoCommand> parse_command_line(
    std::vector<std::string> arguments);

}  // namespace aprsim::client
