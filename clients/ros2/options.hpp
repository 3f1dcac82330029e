#pragma once

#include <optional>
#include <string>

#include "clients/ros2/bridge.hpp"

namespace aprsim::ros2 {

/// The command line.
struct Options {
  BridgeOptions bridge;
  unsigned domain = 0;              ///< of DDS, 0 to 232
  std::string ros_namespace = "/";  ///< absolute, without a slash at the end
};

/// Reads the command line. Absent: the process is to end with `exit_code`, all messages are
/// written.
[[nodiscard]] std::optional<Options> parse_options(int argc, const char* const* argv,
                                                   int& exit_code);

}  // namespace aprsim::ros2
