#pragma once

#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// Anybody's servers against the written rules.
namespace aprsim::client {

/// Checks a robot's CRCL server against the written rules.
struct ConformCrclCommand {
  std::string address;  ///< HOST:PORT; empty = of the cell that runs, by the robot
  std::string robot;
  bool allow_motion = false;  ///< also what moves the robot, a little
  std::string sensor;         ///< for guards; empty = one of the known names
};
/// The same of the conveyor's Modbus server.
struct ConformModbusCommand {
  std::string address;        ///< HOST:PORT; empty = of the cell that runs
  bool allow_motion = false;  ///< also what writes, and runs the belt slowly
};
/// Prints the rules as a page.
struct ConformClausesCommand {};

[[nodiscard]] Outcome<void> run_command(const ConformCrclCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConformModbusCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConformClausesCommand& command, Console& console);

/// Their words and options.
void add_conform(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
