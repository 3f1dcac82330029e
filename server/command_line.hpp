#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/config/config.hpp"
#include "server/replay/motion_options.hpp"
#include "server/replay/replay_files.hpp"

namespace aprsim::server {

/// The command line besides the configuration itself.
struct Invocation {
  Config config;
  std::string ports_file;           ///< empty = none
  std::vector<std::string> replay;  ///< journals of a run to be run again, then leave
  journal::ReplayPart replay_part;
  std::optional<double> replay_speed;  ///< absent = as fast as possible
  bool serve_replay = false;           ///< let it be watched
  bool json = false;                   ///< what a replay has found, as an object
  MotionOptions motion;                ///< of a replay: where to write how things moved
  bool exit_on_stdin_eof = false;      ///< stop when standard input ends
  bool demo = false;                   ///< start the kitting controller, too
  bool check_only = false;             ///< load configuration and scene, then leave
  bool print_config = false;           ///< print the effective configuration, then leave
  bool list_keys = false;              ///< list the configuration's keys, then leave
};

/// Parses the daemon's arguments and loads the configuration. Prints help, version or one line of
/// error itself; then the process's exit code is in `exit_code` and the result is empty.
[[nodiscard]] std::optional<Invocation> parse_command_line(int argc, char** argv, int& exit_code);

}  // namespace aprsim::server
