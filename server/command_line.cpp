#include "server/command_line.hpp"

#include <cstdlib>
#include <iostream>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "server/access/token.hpp"
#include "server/config/version.hpp"
#include "world/base/usage/usage_error.hpp"
#include "world/cell/kept_asserts.hpp"
#include "world/scene/data_paths.hpp"

namespace aprsim::server {
namespace {

using Overrides = std::vector<std::pair<std::string, std::string>>;

std::string scene_list() {
  std::string names;
  for (const auto& name : scene::scene_names(scene::default_data_paths())) {
    names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

std::string version_text() {
  const auto kept = world::kept_asserts();
  return fmt::format("aprsimd {}\nasserts kept: {}", kVersion,
                     kept.empty() ? "none" : fmt::format("{}", fmt::join(kept, ", ")));
}

/// The arguments as they were given.
struct Arguments {
  std::string config_file, scene, speed, seed, time, token_file, journal, from, to;
  std::vector<std::string> assignments, pacers, extensions;
  std::optional<double> poll_period_s;
  bool any_port = false;
  bool no_web = false;
  bool insecure_control = false;
  bool allow_foreign_states = false;
  Invocation invocation;  // arguments that need no conversion
};

// The help lists options in the order in which they are added.

void add_cell_options(CLI::App& app, Arguments& given) {
  app.add_option("--config", given.config_file, "Configuration file (YAML)");
  app.add_option("--scene", given.scene, "Scene: one of " + scene_list() + ", or a file");
  app.add_option("--seed", given.seed, "Random seed, in place of the scene's");
  app.add_option(
      "--speed", given.speed,
      "Ratio of simulated to real time; max = as fast as possible; stepped = paused until "
      "a client steps");
  app.add_option(
      "--time", given.time,
      "Time mode: real, or virtual, where the status polls of CRCL clients advance time");
  app.add_option("--poll-period", given.poll_period_s,
                 "Simulated time of one poll in virtual time, as in 25ms")
      ->transform(CLI::AsNumberWithUnit(std::map<std::string, double>{{"ms", 1e-3}, {"s", 1}},
                                        CLI::AsNumberWithUnit::UNIT_REQUIRED, "TIME"));
  app.add_option(
         "--pacers", given.pacers,
         "Clients that pace virtual time, as in crcl.fanuc,crcl.motoman,modbus; time begins "
         "when all are connected and waits for each")
      ->delimiter(',');
  app.add_option("--extensions", given.extensions,
                 "Look up the libraries of a scene's devices in this directory, too")
      ->type_name("DIR")
      ->take_all()
      ->allow_extra_args(false);
}

void add_daemon_options(CLI::App& app, Arguments& given) {
  app.add_option("--set", given.assignments, "Set a configuration key, as in --set modbus.port=502")
      ->type_name("KEY=VALUE")
      ->take_all();
  app.add_flag("--any-port", given.any_port, "Use free ports that the system chooses");
  app.add_option("--token-file", given.token_file,
                 "Read the access token from the first line of this file (default: the variable "
                 "APRSIM_TOKEN)");
  app.add_flag(
      "--insecure-control", given.insecure_control,
      "Allow all commands over gRPC and on the page without credentials, also from other machines");
  app.add_flag("--allow-foreign-states", given.allow_foreign_states,
               "Load saved states from other users and machines, too");
  app.add_option("--ports-file", given.invocation.ports_file,
                 "Write the ports as JSON to this file once all listeners are open");
  app.add_flag("--exit-on-stdin-eof", given.invocation.exit_on_stdin_eof,
               "Stop when standard input ends, for example when the parent process exits");
  app.add_option("--journal", given.journal,
                 "Record the run in this file, or in files in this directory");
}

void add_replay_options(CLI::App& app, Arguments& given) {
  app.add_option(
         "--replay", given.invocation.replay,
         "Replay a recorded run, compare it step by step and exit; give its files in order, "
         "the first file, or their directory")
      ->type_name("FILE|DIR ...");
  app.add_option("--from", given.from, "Replay from the last checkpoint before this time")
      ->type_name("[EPOCH:]SECONDS")
      ->needs("--replay");
  app.add_option("--to", given.to, "Replay up to this time")
      ->type_name("[EPOCH:]SECONDS")
      ->needs("--replay");
  app.add_flag("--serve", given.invocation.serve_replay,
               "Show the replay to browsers and gRPC clients at --speed (default 1)")
      ->needs("--replay");
  app.add_flag("--json", given.invocation.json, "Print the result of the replay as a JSON object")
      ->needs("--replay");
}

void add_motion_options(CLI::App& app, Arguments& given) {
  MotionOptions& motion = given.invocation.motion;
  app.add_option("--motion", motion.file,
                 "Write the motion of all bodies during the replay to this file, for exports")
      ->type_name("FILE")
      ->needs("--replay")
      ->excludes("--serve");
  app.add_option("--video", motion.video,
                 "Write the pictures of --camera during the replay to this file, one JPEG after "
                 "another")
      ->type_name("FILE")
      ->needs("--replay")
      ->excludes("--serve");
  app.add_option("--camera", motion.camera, "Camera of the recorded scene, for --video")
      ->type_name("NAME")
      ->needs("--video");
  app.get_option("--video")->needs("--camera");
  app.add_option("--motion-rate", motion.rate_hz,
                 "Samples of --motion and --video per simulated second (default 50)")
      ->type_name("HZ")
      ->check(CLI::Range(0.01, 1000.0))
      ->needs("--replay");
  app.add_option("--motion-from", motion.from_s, "Write samples from this simulated time on")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber)
      ->needs("--replay");
  app.add_option("--motion-to", motion.to_s, "Write samples up to this simulated time")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber)
      ->needs("--replay");
}

void add_modes(CLI::App& app, Arguments& given) {
  app.add_flag("--demo", given.invocation.demo,
               "Start the kitting controller, which fills and empties kits until it is stopped");
  app.add_flag("--check", given.invocation.check_only, "Check configuration and scene, then exit");
  app.add_flag("--print-config", given.invocation.print_config,
               "Print the effective configuration, then exit");
  app.add_flag("--list-keys", given.invocation.list_keys,
               "List every configuration key with value, meaning and accepted values, then exit");
  app.add_flag("--no-web", given.no_web, "Disable the web page");
}

Result<Overrides> overrides_of(const Arguments& given) {
  Overrides overrides;
  for (const auto& assignment : given.assignments) {
    const auto equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
      return fail(ErrorCode::kInvalidArgument, "set",
                  "--set " + assignment + ": expected KEY=VALUE");
    }
    overrides.emplace_back(assignment.substr(0, equals), assignment.substr(equals + 1));
  }
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) overrides.emplace_back(key, value);
  };
  add("scene", given.scene);
  add("seed", given.seed);
  add("speed", given.speed);
  add("access.insecure_control", given.insecure_control ? "true" : "");
  add("access.allow_foreign_states", given.allow_foreign_states ? "true" : "");
  add("time.mode", given.time);
  add("time.poll_period_ms",
      given.poll_period_s ? fmt::format("{:g}", 1e3 * *given.poll_period_s) : "");
  add("time.pacers",
      given.pacers.empty() ? "" : fmt::format("[{}]", fmt::join(given.pacers, ", ")));
  return overrides;
}

/// Every user of this machine can read a command line.
Result<void> check_token_is_secret(const Arguments& given, const Config& config) {
  if (config.web.token.empty()) return {};
  const auto file = load_config(given.config_file, {});
  if (file && file->web.token == config.web.token) return {};
  return fail(ErrorCode::kInvalidArgument, "web.token",
              "web.token: not allowed on the command line, which other users can read; use "
              "--token-file, a configuration file or the variable APRSIM_TOKEN");
}

Result<void> read_replay_part(const Arguments& given, journal::ReplayPart& part) {
  for (const auto& [text, moment] :
       {std::pair(&given.from, &part.from), std::pair(&given.to, &part.to)}) {
    if (text->empty()) continue;
    const auto read = journal::to_run_moment(*text);
    if (!read) return tl::unexpected(read.error());
    *moment = *read;
  }
  return {};
}

/// Applies arguments that override the configuration file and --set.
Result<void> set_last(const Arguments& given, const Invocation& invocation, Config& config) {
  config.extensions.insert(config.extensions.end(), given.extensions.begin(),
                           given.extensions.end());
  if (!given.journal.empty()) config.journal.place = given.journal;
  if (!given.token_file.empty()) config.web.token_file = given.token_file;
  if (!invocation.print_config && !invocation.list_keys) {
    if (auto ok = resolve_token(config.web, std::getenv("APRSIM_TOKEN")); !ok) return ok;
  }
  if (given.no_web) config.web.enabled = false;
  if (given.any_port) use_free_ports(config);
  return {};
}

Result<Invocation> invocation_of(const Arguments& given) {
  const auto overrides = overrides_of(given);
  if (!overrides) return tl::unexpected(overrides.error());
  auto config = load_config(given.config_file, *overrides);
  if (!config) return tl::unexpected(config.error());
  if (auto ok = check_token_is_secret(given, *config); !ok) return tl::unexpected(ok.error());
  Invocation invocation = given.invocation;
  if (invocation.demo && config->time.clients_pace) {
    return fail(ErrorCode::kInvalidArgument, "demo", "--demo: not possible in virtual time");
  }
  if (auto ok = read_replay_part(given, invocation.replay_part); !ok) {
    return tl::unexpected(ok.error());
  }
  const bool paced = !given.speed.empty() || invocation.serve_replay;
  if (paced && config->speed.mode == Speed::Mode::kFactor) {
    invocation.replay_speed = config->speed.factor;
  }
  if (auto ok = set_last(given, invocation, *config); !ok) return tl::unexpected(ok.error());
  invocation.config = std::move(*config);
  return invocation;
}

}  // namespace

std::optional<Invocation> parse_command_line(int argc, char** argv, int& exit_code) {
  CLI::App app{
      "aprsimd: simulates the APRS kitting cell. It serves CRCL for each robot, Modbus/TCP for the "
      "conveyor, gRPC for telemetry and control, and a web page.",
      "aprsimd"};
  Arguments given;
  add_cell_options(app, given);
  add_daemon_options(app, given);
  add_replay_options(app, given);
  add_motion_options(app, given);
  add_modes(app, given);
  app.set_version_flag("--version", version_text());
  app.footer("\nSee also: aprsimd token --help (access tokens for gRPC and the page)");
  exit_code = 0;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // CLI11 reports help and version as errors of code 0.
    if (error.get_exit_code() == 0) {
      app.exit(error);
    } else {
      std::cerr << "aprsimd: " << usage::usage_error(app, error);
      exit_code = 2;
    }
    return std::nullopt;
  }
  auto invocation = invocation_of(given);
  if (!invocation) {
    std::cerr << "aprsimd: " << invocation.error().message << "\n";
    exit_code = 2;
    return std::nullopt;
  }
  return std::move(*invocation);
}

}  // namespace aprsim::server
