#pragma once

#include <optional>

#include "clients/aprsim/commands/command_group.hpp"

/// Commands for the belt, over Modbus.
namespace aprsim::client {

struct ConveyorSetCommand {
  std::optional<double> speed_m_s;
  std::optional<double> speed_percent;  ///< of the register's full scale
  std::optional<bool> forward;
  bool stop = false;
  bool secure = false;  ///< over Modbus Security
  double full_scale_m_s = 0.32768;
  bool one_is_forward = true;
};
struct ConveyorStatusCommand {
  bool secure = false;  ///< over Modbus Security
  double full_scale_m_s = 0.32768;
  bool one_is_forward = true;
};
struct ConveyorMapCommand {
  double full_scale_m_s = 0.32768;
  bool one_is_forward = true;
};

[[nodiscard]] Outcome<void> run_command(const ConveyorSetCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConveyorStatusCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConveyorMapCommand& command, Console& console);

/// Their words and options.
void add_conveyor(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
