#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace aprsim::client {

/// What is wrong with a command line, in one sentence, what was probably meant, and where to find
/// out. `app` is the parser after it has thrown `error`.
[[nodiscard]] std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace aprsim::client
