#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/config/config.hpp"
#include "server/replay/motion_options.hpp"
#include "server/replay/replay_files.hpp"

namespace aprsim::server {

/// The command line.
struct Invocation {
  Config config;
  std::string ports_file;           ///< empty = none
  std::vector<std::string> replay;  ///< journals of a run to replay
  journal::ReplayPart replay_part;
  std::optional<double> replay_speed;  ///< absent = as fast as possible
  bool serve_replay = false;           ///< show the replay to clients
  bool json = false;                   ///< print the result of a replay as JSON
  MotionOptions motion;                ///< where a replay writes motion
  bool exit_on_stdin_eof = false;      ///< stop when standard input ends
  bool demo = false;                   ///< start the kitting controller
  bool check_only = false;             ///< check configuration and scene, then exit
  bool print_config = false;           ///< print the configuration, then exit
  bool list_keys = false;              ///< list the configuration keys, then exit
};

/// Parses the daemon's arguments and loads the configuration. Where it prints help, version or an
/// error instead, the result is empty and `exit_code` is set.
[[nodiscard]] std::optional<Invocation> parse_command_line(int argc, char** argv, int& exit_code);

}  // namespace aprsim::server
