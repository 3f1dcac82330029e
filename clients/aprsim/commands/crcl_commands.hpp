#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"
#include "crcl/motion_commands.hpp"

/// Commands for robots, over CRCL.
namespace aprsim::client {

struct CrclStatusCommand {
  std::string robot;
  bool watch = false;       ///< one line per sample until interrupted
  double rate_hz = 10;      ///< of these
  std::uint64_t count = 0;  ///< samples before exit; 0 = unlimited
};
struct CrclInitCommand {
  std::string robot;
};
struct CrclStopCommand {
  std::vector<std::string> robots;  ///< empty = all
  crcl::StopCondition condition = crcl::StopCondition::kNormal;
};
struct CrclGripperCommand {
  std::string robot;
  double setting = 0;  ///< 0 closed .. 1 open
};
/// Moves one joint, or the tool straight along one axis of the robot's frame.
struct CrclJogCommand {
  std::string robot;
  std::optional<int> joint;     ///< 1-based
  char axis = 'x';              ///< when no joint is given
  double by = 0;                ///< degrees or millimetres on a new socket
  std::optional<double> speed;  ///< degrees or millimetres per second
  bool init = false;            ///< InitCanon first
  double timeout_s = 120;       ///< after which the robot is stopped
};

[[nodiscard]] Outcome<void> run_command(const CrclStatusCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclInitCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclStopCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclGripperCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclJogCommand& command, Console& console);

/// Their words and options.
void add_crcl(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
