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

/// Everything that may stand on the command line, as it stands there.
struct Arguments {
  std::string config_file, scene, speed, seed, time, token_file, journal, from, to;
  std::vector<std::string> assignments, pacers;
  std::optional<double> poll_period_s;
  bool any_port = false;
  bool no_web = false;
  bool insecure_control = false;
  bool allow_foreign_states = false;
  Invocation invocation;  // parts that need no reading
};

// Help lists the options in the order in which they are added.

void add_cell_options(CLI::App& app, Arguments& given) {
  app.add_option("--config", given.config_file, "Configuration file (YAML)");
  app.add_option("--scene", given.scene, "Scene: a name (" + scene_list() + ") or a file");
  app.add_option("--seed", given.seed, "Seed of everything random");
  app.add_option("--speed", given.speed,
                 "Ratio of simulated to real time, max = as fast as possible, stepped = paused "
                 "until a client steps");
  app.add_option("--time", given.time,
                 "real, or virtual: simulated time passes as CRCL clients poll their status");
  app.add_option("--poll-period", given.poll_period_s,
                 "Simulated time that a poll takes in virtual time, as in 25ms")
      ->transform(CLI::AsNumberWithUnit(std::map<std::string, double>{{"ms", 1e-3}, {"s", 1}},
                                        CLI::AsNumberWithUnit::UNIT_REQUIRED, "TIME"));
  app.add_option("--pacers", given.pacers,
                 "Who paces virtual time, as in crcl.fanuc,crcl.motoman,modbus: it begins when all "
                 "are there and waits for each")
      ->delimiter(',');
}

void add_daemon_options(CLI::App& app, Arguments& given) {
  app.add_option("--set", given.assignments,
                 "Set one configuration key, as in --set modbus.port=502")
      ->type_name("KEY=VALUE")
      ->take_all();
  app.add_flag("--any-port", given.any_port, "Let the system pick every port");
  app.add_option("--token-file", given.token_file,
                 "File whose first line is the access token (default: the variable APRSIM_TOKEN)");
  app.add_flag(
      "--insecure-control", given.insecure_control,
      "Let who has no credentials do everything over gRPC and on the page, also from other "
      "machines");
  app.add_flag("--allow-foreign-states", given.allow_foreign_states,
               "Load saved states from other users and machines, too");
  app.add_option("--ports-file", given.invocation.ports_file,
                 "Write the ports as JSON to this file once everything listens");
  app.add_option("--journal", given.journal,
                 "Record the run in this file, or in files in this directory");
}

void add_replay_options(CLI::App& app, Arguments& given) {
  app.add_option("--replay", given.invocation.replay,
                 "Run a recorded run again, compare it step by step, then leave; a run's files in "
                 "their order, or the first, or their directory")
      ->type_name("FILE|DIR ...");
  app.add_option("--from", given.from, "Of a replay: begin at the last checkpoint before this time")
      ->type_name("[EPOCH:]SECONDS")
      ->needs("--replay");
  app.add_option("--to", given.to, "Of a replay: end at this time")
      ->type_name("[EPOCH:]SECONDS")
      ->needs("--replay");
  app.add_flag("--serve", given.invocation.serve_replay,
               "Of a replay: let browsers and gRPC clients watch it at --speed (default 1)")
      ->needs("--replay");
  app.add_flag("--json", given.invocation.json, "Of a replay: what it has found as a JSON object")
      ->needs("--replay");
}

void add_motion_options(CLI::App& app, Arguments& given) {
  CLI::Option* motion =
      app.add_option("--motion", given.invocation.motion.file,
                     "Of a replay: also write how everything moves into this file, for exports")
          ->type_name("FILE")
          ->needs("--replay")
          ->excludes("--serve");
  app.add_option("--motion-rate", given.invocation.motion.rate_hz,
                 "Pictures of it a second of simulated time (default 50)")
      ->type_name("HZ")
      ->check(CLI::Range(0.01, 1000.0))
      ->needs(motion);
  app.add_option("--motion-from", given.invocation.motion.from_s, "From this simulated time on")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber)
      ->needs(motion);
  app.add_option("--motion-to", given.invocation.motion.to_s, "Until this simulated time")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber)
      ->needs(motion);
}

void add_modes(CLI::App& app, Arguments& given) {
  app.add_flag(
      "--demo", given.invocation.demo,
      "Also start the kitting controller, which fills kits and empties them again, for ever");
  app.add_flag("--check", given.invocation.check_only, "Check configuration and scene, then leave");
  app.add_flag("--print-config", given.invocation.print_config,
               "Print the effective configuration, then leave");
  app.add_flag("--list-keys", given.invocation.list_keys,
               "List every configuration key: its value, meaning and what it accepts; then leave");
  app.add_flag("--no-web", given.no_web, "Do not serve the web view");
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

/// Everybody on this machine can read a command line.
Result<void> check_token_is_secret(const Arguments& given, const Config& config) {
  if (config.web.token.empty()) return {};
  const auto file = load_config(given.config_file, {});
  if (file && file->web.token == config.web.token) return {};
  return fail(ErrorCode::kInvalidArgument, "web.token",
              "web.token: not on the command line, which others can read; use --token-file, a "
              "configuration file or the variable APRSIM_TOKEN");
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

/// Arguments that have the last word over the configuration.
Result<void> set_last(const Arguments& given, const Invocation& invocation, Config& config) {
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
    return fail(ErrorCode::kInvalidArgument, "demo",
                "--demo: not in virtual time, which whoever polls would pass");
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
      "aprsimd: a stand-in for the APRS kitting cell. Serves CRCL for each robot, Modbus/TCP for "
      "the conveyor, gRPC for telemetry and control, and a web page that shows it all.",
      "aprsimd"};
  Arguments given;
  add_cell_options(app, given);
  add_daemon_options(app, given);
  add_replay_options(app, given);
  add_motion_options(app, given);
  add_modes(app, given);
  app.set_version_flag("--version", version_text());
  app.footer("\naprsimd token --help: who may what over gRPC and on the page.");
  exit_code = 0;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error) == 0 ? 0 : 2;
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
