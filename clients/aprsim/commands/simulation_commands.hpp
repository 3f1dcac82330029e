#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"
#include "world/api/faults/fault_when.hpp"

/// Commands for the simulation's clock.
namespace aprsim::client {

struct PauseCommand {};
struct ResumeCommand {};
struct StepCommand {
  std::uint64_t steps = 1;
};
struct SpeedCommand {
  std::optional<double> factor;  ///< absent = as fast as possible
};
struct ResetCommand {
  std::optional<std::uint64_t> seed;
  std::string scene;  ///< name of a scene of the daemon, or a local file; empty = unchanged
};
struct RunCommand {
  std::optional<double> time_s;           ///< until this simulated time
  std::vector<std::string> kinds, names;  ///< until an event of these (event_text.hpp)
  std::optional<faults::WhenCrossing>
      beyond;                        ///< until a quantity crosses a limit; only one of the three
  std::uint64_t steps = 10'000'000;  ///< at most
};

[[nodiscard]] Outcome<void> run_command(const PauseCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ResumeCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const StepCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SpeedCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ResetCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const RunCommand& command, Console& console);

/// Their words and options.
void add_simulation(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
