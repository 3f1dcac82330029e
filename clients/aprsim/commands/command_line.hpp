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

/// Why there is nothing to run: help was asked for (exit code 0, text for standard output) or the
/// arguments are wrong (exit code 2, text for standard error that says what was probably meant).
struct NoCommand {
  int exit_code = 2;
  std::string text;
};

/// `arguments` without the program's name.
[[nodiscard]] tl::expected<CommandLine, NoCommand> parse_command_line(
    std::vector<std::string> arguments);

}  // namespace aprsim::client
