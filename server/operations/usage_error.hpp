#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace aprsim::server {

/// Describes an error of the command line: one line that names the argument and suggests the
/// nearest option or command, and one that names the help. `error`: as thrown by app.parse().
[[nodiscard]] std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace aprsim::server
