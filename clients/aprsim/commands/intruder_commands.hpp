#pragma once

#include <array>
#include <optional>

#include "clients/aprsim/commands/command_group.hpp"

/// What the cell's sensors see of a person.
namespace aprsim::client {

struct IntruderCommand {
  std::optional<std::array<double, 2>> xy_m;        ///< where it stands on the floor; absent = gone
  std::array<double, 3> size_m = {0.5, 0.3, 1.75};  ///< a person's
};

[[nodiscard]] Outcome<void> run_command(const IntruderCommand& command, Console& console);

/// Their words and options.
void add_intruder(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
