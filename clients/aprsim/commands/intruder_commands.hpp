#pragma once

#include <array>
#include <optional>

#include "clients/aprsim/commands/command_group.hpp"

/// A person or object that only the cell's sensors detect.
namespace aprsim::client {

struct IntruderCommand {
  std::optional<std::array<double, 2>> xy_m;        ///< position on the floor; absent = removed
  std::array<double, 3> size_m = {0.5, 0.3, 1.75};  ///< a person's
};

[[nodiscard]] Outcome<void> run_command(const IntruderCommand& command, Console& console);

/// Their words and options.
void add_intruder(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
