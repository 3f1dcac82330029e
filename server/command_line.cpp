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

/// "key=value" of --set; false when there is no key.
bool split(const std::string& assignment, Overrides& overrides) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) return false;
  overrides.emplace_back(assignment.substr(0, equals), assignment.substr(equals + 1));
  return true;
}

}  // namespace

std::optional<Invocation> parse_command_line(int argc, char** argv, int& exit_code) {
  CLI::App app{
      "aprsimd: a stand-in for the APRS kitting cell. Serves CRCL for each robot, Modbus/TCP for "
      "the conveyor, gRPC for telemetry and control, and a web page that shows it all.",
      "aprsimd"};
  std::string config_file, scene, speed, seed, time, token_file, journal, from, to;
  std::vector<std::string> assignments, pacers;
  std::optional<double> poll_period_s;
  Invocation invocation;
  bool any_port = false;
  bool no_web = false;
  bool insecure_control = false;
  app.add_option("--config", config_file, "Configuration file (YAML)");
  app.add_option("--scene", scene, "Scene: a name (" + scene_list() + ") or a file");
  app.add_option("--seed", seed, "Seed of everything random");
  app.add_option("--speed", speed,
                 "Ratio of simulated to real time, max = as fast as possible, stepped = paused "
                 "until a client steps");
  app.add_option("--time", time,
                 "real, or virtual: simulated time passes as CRCL clients poll their status");
  app.add_option("--poll-period", poll_period_s,
                 "Simulated time that a poll takes in virtual time, as in 25ms")
      ->transform(CLI::AsNumberWithUnit(std::map<std::string, double>{{"ms", 1e-3}, {"s", 1}},
                                        CLI::AsNumberWithUnit::UNIT_REQUIRED, "TIME"));
  app.add_option("--pacers", pacers,
                 "Who paces virtual time, as in crcl.fanuc,crcl.motoman,modbus: it begins when all "
                 "are there and waits for each")
      ->delimiter(',');
  app.add_option("--set", assignments, "Set one configuration key, as in --set modbus.port=502")
      ->type_name("KEY=VALUE")
      ->take_all();
  app.add_flag("--any-port", any_port, "Let the system pick every port");
  app.add_option("--token-file", token_file,
                 "File whose first line is the access token (default: the variable APRSIM_TOKEN)");
  app.add_flag(
      "--insecure-control", insecure_control,
      "Let who has no credentials do everything over gRPC and on the page, also from other "
      "machines");
  app.add_option("--ports-file", invocation.ports_file,
                 "Write the ports as JSON to this file once everything listens");
  app.add_option("--journal", journal,
                 "Record the run in this file, or in files in this directory");
  app.add_option("--replay", invocation.replay,
                 "Run a recorded run again, compare it step by step, then leave; a run's files in "
                 "their order, or the first, or their directory")
      ->type_name("FILE|DIR ...");
  app.add_option("--from", from, "Of a replay: begin at the last checkpoint before this time")
      ->type_name("[EPOCH:]SECONDS")
      ->needs("--replay");
  app.add_option("--to", to, "Of a replay: end at this time")
      ->type_name("[EPOCH:]SECONDS")
      ->needs("--replay");
  app.add_flag("--serve", invocation.serve_replay,
               "Of a replay: let browsers and gRPC clients watch it at --speed (default 1)")
      ->needs("--replay");
  app.add_flag("--json", invocation.json, "Of a replay: what it has found as a JSON object")
      ->needs("--replay");
  CLI::Option* motion =
      app.add_option("--motion", invocation.motion.file,
                     "Of a replay: also write how everything moves into this file, for exports")
          ->type_name("FILE")
          ->needs("--replay")
          ->excludes("--serve");
  app.add_option("--motion-rate", invocation.motion.rate_hz,
                 "Pictures of it a second of simulated time (default 50)")
      ->type_name("HZ")
      ->check(CLI::Range(0.01, 1000.0))
      ->needs(motion);
  app.add_option("--motion-from", invocation.motion.from_s, "From this simulated time on")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber)
      ->needs(motion);
  app.add_option("--motion-to", invocation.motion.to_s, "Until this simulated time")
      ->type_name("SECONDS")
      ->check(CLI::NonNegativeNumber)
      ->needs(motion);
  app.add_flag(
      "--demo", invocation.demo,
      "Also start the kitting controller, which fills kits and empties them again, for ever");
  app.add_flag("--check", invocation.check_only, "Check configuration and scene, then leave");
  app.add_flag("--print-config", invocation.print_config,
               "Print the effective configuration, then leave");
  app.add_flag("--list-keys", invocation.list_keys,
               "List every configuration key: its value, meaning and what it accepts; then leave");
  app.add_flag("--no-web", no_web, "Do not serve the web view");
  app.set_version_flag("--version", version_text());
  app.footer("\naprsimd token --help: who may what over gRPC and on the page.");
  exit_code = 0;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error) == 0 ? 0 : 2;
    return std::nullopt;
  }

  Overrides overrides;
  for (const auto& assignment : assignments) {
    if (!split(assignment, overrides)) {
      std::cerr << "aprsimd: --set " << assignment << ": expected KEY=VALUE\n";
      exit_code = 2;
      return std::nullopt;
    }
  }
  if (!scene.empty()) overrides.emplace_back("scene", scene);
  if (!seed.empty()) overrides.emplace_back("seed", seed);
  if (!speed.empty()) overrides.emplace_back("speed", speed);
  if (insecure_control) overrides.emplace_back("access.insecure_control", "true");
  if (!time.empty()) overrides.emplace_back("time.mode", time);
  if (poll_period_s) {
    overrides.emplace_back("time.poll_period_ms", fmt::format("{:g}", 1e3 * *poll_period_s));
  }
  if (!pacers.empty()) {
    overrides.emplace_back("time.pacers", fmt::format("[{}]", fmt::join(pacers, ", ")));
  }
  auto config = load_config(config_file, overrides);
  if (!config) {
    std::cerr << "aprsimd: " << config.error().message << "\n";
    exit_code = 2;
    return std::nullopt;
  }
  // Everybody on this machine can read a command line.
  if (!config->web.token.empty()) {
    const auto file = load_config(config_file, {});
    if (!file || file->web.token != config->web.token) {
      std::cerr << "aprsimd: web.token: not on the command line, which others can read; use "
                   "--token-file, a configuration file or the variable APRSIM_TOKEN\n";
      exit_code = 2;
      return std::nullopt;
    }
  }
  if (invocation.demo && config->time.clients_pace) {
    std::cerr << "aprsimd: --demo: not in virtual time, which whoever polls would pass\n";
    exit_code = 2;
    return std::nullopt;
  }
  for (const auto& [text, moment] : {std::pair(&from, &invocation.replay_part.from),
                                     std::pair(&to, &invocation.replay_part.to)}) {
    if (text->empty()) continue;
    const auto read = journal::to_run_moment(*text);
    if (!read) {
      std::cerr << "aprsimd: " << read.error().message << "\n";
      exit_code = 2;
      return std::nullopt;
    }
    *moment = *read;
  }
  const bool paced = !speed.empty() || invocation.serve_replay;
  if (paced && config->speed.mode == Speed::Mode::kFactor) {
    invocation.replay_speed = config->speed.factor;
  }
  invocation.config = std::move(*config);
  if (!journal.empty()) invocation.config.journal.place = journal;
  if (!token_file.empty()) invocation.config.web.token_file = token_file;
  if (!invocation.print_config && !invocation.list_keys) {
    if (auto ok = resolve_token(invocation.config.web, std::getenv("APRSIM_TOKEN")); !ok) {
      std::cerr << "aprsimd: " << ok.error().message << "\n";
      exit_code = 2;
      return std::nullopt;
    }
  }
  if (no_web) invocation.config.web.enabled = false;
  if (any_port) use_free_ports(invocation.config);
  return invocation;
}

}  // namespace aprsim::server
