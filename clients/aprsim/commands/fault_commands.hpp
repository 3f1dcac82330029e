#pragma once

#include <cstdint>
#include <string>

#include "clients/aprsim/commands/command_group.hpp"
#include "clients/aprsim/text/fault_request.hpp"

/// Injected faults.
namespace aprsim::client {

struct FaultListCommand {};
struct FaultKindsCommand {
  bool markdown = false;  ///< as FAULTS.md
};
struct FaultEndCommand {
  std::uint64_t id = 0;
};
struct FaultEventCommand {
  std::string event;
};

[[nodiscard]] Outcome<void> run_command(const FaultListCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FaultKindsCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FaultInjectCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FaultEndCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FaultEventCommand& command, Console& console);

/// Their words and options.
void add_fault(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
