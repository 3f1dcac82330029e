#pragma once

#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// Conformance tests of any server.
namespace aprsim::client {

/// Tests a CRCL server.
struct ConformCrclCommand {
  std::string address;  ///< HOST:PORT; empty = the robot's in the running cell
  std::string robot;
  bool allow_motion = false;  ///< include checks that move the robot a little
  std::string sensor;         ///< for guards; empty = one of the known names
};
/// Tests the conveyor's Modbus server, or one that the running scene describes.
struct ConformModbusCommand {
  std::string server;         ///< name in the scene; empty = the conveyor's
  std::string address;        ///< HOST:PORT; empty = the running cell's
  bool allow_motion = false;  ///< include checks that write and run the belt slowly
  bool secure = false;        ///< Modbus Security: TLS with the certificate of the endpoints
};
/// Prints the rules as Markdown.
struct ConformClausesCommand {};

[[nodiscard]] Outcome<void> run_command(const ConformCrclCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConformModbusCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConformClausesCommand& command, Console& console);

/// Their words and options.
void add_conform(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
