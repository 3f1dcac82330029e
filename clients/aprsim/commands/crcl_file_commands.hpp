#pragma once

#include <string>

#include "clients/aprsim/commands/command_group.hpp"

/// CRCL documents in files.
namespace aprsim::client {

struct CrclSendCommand {
  std::string file;  ///< CRCLCommandInstance documents
  std::string robot;
  double timeout_s = 120;
};
struct CrclRunCommand {
  std::string file;  ///< one CRCLProgram document
  std::string robot;
  double timeout_s = 120;  ///< for each command
};
struct CrclValidateCommand {
  std::string file;  ///< any CRCL documents
};

[[nodiscard]] Outcome<void> run_command(const CrclSendCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclRunCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclValidateCommand& command, Console& console);

/// Their words and options.
void add_crcl_files(CLI::App& app, CommandLine& line);

}  // namespace aprsim::client
