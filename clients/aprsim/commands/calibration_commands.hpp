#pragma once

#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"

/// A cell fitted to recordings of its original, and compared with them.
namespace aprsim::client {

/// Estimates parameters of a scene from recordings.
struct CalibrateCommand {
  std::vector<std::string> captures;  ///< journals, force logs, camera lines
  std::vector<std::string> options;   ///< as given, of aprsim.calibration in Python
};

/// Compares a cell with a recording.
struct CompareCommand {
  std::string capture;               ///< journal, force log or camera lines
  std::vector<std::string> options;  ///< as given, of aprsim.calibration in Python
};

/// Each becomes the Python program; returns only when that cannot be started.
[[nodiscard]] Outcome<void> run_command(const CalibrateCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CompareCommand& command, Console& console);

/// Their words and options.
void add_calibration(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
