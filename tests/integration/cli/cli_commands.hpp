#pragma once

#include <string>
#include <vector>

#include "tests/support/daemon_process.hpp"

namespace aprsim::test {

/// The command line of aprsim for a running daemon.
inline std::vector<std::string> cli_command(const DaemonProcess& daemon,
                                            const std::vector<std::string>& arguments) {
  std::vector<std::string> argv = {std::string(APRSIM_BIN_DIR) + "/aprsim", "--ports-file",
                                   daemon.ports_file()};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  return argv;
}

inline ProcessResult run_aprsim(const DaemonProcess& daemon,
                                const std::vector<std::string>& arguments) {
  return run_process(cli_command(daemon, arguments), std::chrono::seconds(60));
}

inline std::string example(const char* name) {
  return std::string(APRSIM_SOURCE_DIR) + "/clients/aprsim/examples/" + name;
}

}  // namespace aprsim::test
