#pragma once

#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// Commands to the devices of extensions.
namespace aprsim::client {

struct DeviceSetCommand {
  std::string device, signal;
  double value = 0;
};

[[nodiscard]] Outcome<void> run_command(const DeviceSetCommand& command, Console& console);

/// Their words and options.
void add_device(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
