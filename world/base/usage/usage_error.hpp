#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace aprsim::usage {

/// The message for a wrong command line: its error, a suggestion, and the help to read. `app` is
/// the parser that threw `error`.
[[nodiscard]] std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace aprsim::usage
