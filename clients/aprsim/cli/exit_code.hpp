#pragma once

#include <array>
#include <string_view>

#include "clients/wires/outcome.hpp"

namespace aprsim::client {

struct ExitCode {
  int code;
  std::string_view meaning;
};

/// All exit codes of the program.
inline constexpr std::array kExitCodes{
    ExitCode{0, "success"},
    ExitCode{1,
             "refused or failed, or an unexpected result: a robot's error, a "
             "document that is not valid, a cell or belt stopped by a fault"},
    ExitCode{2, "wrong arguments or file"},
    ExitCode{3, "no connection"},
    ExitCode{4, "timeout"},
    ExitCode{130,
             "interrupted by Ctrl-C or SIGTERM; motion that the command had started was "
             "stopped first; a second Ctrl-C exits at once"},
};

/// The exit code of a failure.
[[nodiscard]] constexpr int exit_code(FailureKind kind) {
  switch (kind) {
    case FailureKind::kUnauthenticated:
    case FailureKind::kRefused:
    case FailureKind::kCheck:
      return 1;
    case FailureKind::kUsage:
      return 2;
    case FailureKind::kConnection:
      return 3;
    case FailureKind::kTimeout:
      return 4;
    case FailureKind::kInterrupted:
      return 130;
  }
  return 1;
}

}  // namespace aprsim::client
