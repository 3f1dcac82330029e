#pragma once

#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// Modbus servers that the running scene describes.
namespace aprsim::client {

struct ModbusMapCommand {
  std::string server;  ///< empty = all
};

[[nodiscard]] Outcome<void> run_command(const ModbusMapCommand& command, Console& console);

/// Their words and options.
void add_modbus(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
