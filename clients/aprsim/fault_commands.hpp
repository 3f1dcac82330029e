#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "clients/aprsim/command_group.hpp"
#include "world/fault_kinds/fault_when.hpp"

/// Injected faults.
namespace aprsim::client {

struct FaultListCommand {};
struct FaultKindsCommand {
  bool markdown = false;  ///< as FAULTS.md
};
struct FaultInjectCommand {
  std::string kind;
  std::string target;                        ///< as the kind says; empty = none
  std::map<std::string, double> parameters;  ///< SI
  std::optional<double> at_s;                ///< simulated time since the last reset
  std::optional<faults::FaultWhen> when;     ///< never with at_s
  std::optional<double> for_s;               ///< absent = until it is ended
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
