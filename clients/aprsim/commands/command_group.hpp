#pragma once

#include "clients/wires/outcome.hpp"

namespace CLI {
class App;
}

/// A group of commands consists of their structs, a run_command for each, and one function that
/// declares their words and options to the parser of the command above them.
namespace aprsim::client {

struct CommandLine;
struct Console;

}  // namespace aprsim::client
