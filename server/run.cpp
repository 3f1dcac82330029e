#include "server/run.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <spdlog/spdlog.h>

#include "proto/journal/journal_place.hpp"
#include "server/access/exposure.hpp"
#include "server/access/token_command.hpp"
#include "server/command_line.hpp"
#include "server/config/config.hpp"
#include "server/config/version.hpp"
#include "server/daemon.hpp"
#include "server/listeners/server_options.hpp"
#include "server/operations/logging.hpp"
#include "server/operations/ports_file.hpp"
#include "server/operations/process.hpp"
#include "server/operations/service_manager.hpp"
#include "server/operations/stop_deadline.hpp"
#include "server/replay/motion_file.hpp"
#include "server/replay/replay_daemon.hpp"
#include "server/replay/replay_files.hpp"
#include "server/replay/replay_pace.hpp"
#include "server/replay/video_file.hpp"
#include "world/base/files/draft_file.hpp"
#include "world/base/process/input_end.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {
namespace {

/// Prints an error; returns exit code 1.
int refuse(const std::string& message) {
  // In one write, since the log's thread writes there too.
  std::cerr << "aprsimd: " + message + "\n" << std::flush;
  return EXIT_FAILURE;
}

/// Returns the exit code, but 1 instead of 0 where standard output could not be written.
int check_output(int exit_code) {
  if (std::cout.flush() || exit_code != EXIT_SUCCESS) return exit_code;
  return refuse("cannot write the output");
}

void announce(const Ports& ports, const Config& config) {
  for (const auto& [name, port] : ports) spdlog::info("listening: {} on port {}", name, port);
  for (const std::string& line : exposures(config, ports)) spdlog::warn("{}", line);
  if (const auto web = ports.find("web"); web != ports.end()) {
    const auto outside = outside_addresses(config.web.address);
    // Browsers accept either name; the numeric one needs no resolver.
    std::string host = outside.empty() ? config.web.address : outside.front();
    if (host == "localhost") host = "127.0.0.1";
    spdlog::info("web page: {}://{}/", config.tls.certificate ? "https" : "http",
                 host_and_port(host, web->second));
  }
}

/// With a misspelt name the robot would silently keep its defaults.
void warn_of_unknown_robots(const Config& config, const scene::Scene& scene) {
  for (const std::string& key : keys_of_unknown_robots(config, robots_of(scene))) {
    std::cerr << "aprsimd: warning: " << key << ": scene " << scene.name << " has no such robot"
              << std::endl;
  }
}

/// Writes the ports again where they have changed: another scene has other robots or cameras.
void follow_ports(const Ports& now, Ports& written, const Invocation& invocation, PortsFile& file) {
  if (now == written) return;
  for (const auto& [name, port] : now) {
    const auto before = written.find(name);
    if (before != written.end() && before->second == port) continue;
    spdlog::info("listening: {} on port {}", name, port);
    for (const std::string& line : exposures(invocation.config, {{name, port}})) {
      spdlog::warn("{}", line);
    }
  }
  written = now;
  if (invocation.ports_file.empty()) return;
  if (auto ok = file.write(invocation.ports_file, now); !ok) {
    spdlog::error("{}", ok.error().message);
  }
}

/// Serves until a signal. Exit code 0.
template <typename Served>
int serve_until_signal(Served& daemon, const Invocation& invocation,
                       const std::function<bool()>& makes_progress) {
  constexpr std::chrono::milliseconds kReportPeriod{500};
  if (invocation.exit_on_stdin_eof) process::stop_when_input_ends();
  PortsFile ports_file;
  auto ports = daemon.start();
  if (!ports) return refuse(ports.error().message);
  announce(*ports, invocation.config);
  if (!invocation.ports_file.empty()) {
    if (auto ok = ports_file.write(invocation.ports_file, *ports); !ok) {
      return refuse(ok.error().message);
    }
  }
  if constexpr (std::is_same_v<Served, Daemon>) {
    daemon.on_ports([&](const Ports& now) { follow_ports(now, *ports, invocation, ports_file); });
  }
  ServiceManager service_manager;
  service_manager.ready();
  // SIGHUP of a terminal that closes means the end.
  const bool reloads = !has_terminal();
  std::optional<int> signal;
  const auto period = std::min(service_manager.period().value_or(kReportPeriod), kReportPeriod);
  while (!(signal = wait_for_signal(period)) || (reloads && *signal == SIGHUP)) {
    if (signal) daemon.reload();
    service_manager.working(makes_progress(), daemon.problem());
  }
  service_manager.stopping();
  spdlog::info("signal {}: stopping", *signal);
  unblock_signals();
  const StopDeadline deadline([&] {
    ports_file.remove();
    daemon.finish_journal();
  });
  daemon.stop();
  spdlog::info("stopped");
  return EXIT_SUCCESS;
}

int serve(const Invocation& invocation, std::shared_ptr<const scene::Scene> scene) {
  share_memory_pools();
  block_signals();
  if (auto ok = raise_file_limit(needed_files(invocation.config, *scene)); !ok) {
    return refuse(ok.error().message);
  }
  const Logging logging(invocation.config.log_level);
  spdlog::info("aprsimd {}: scene {}, speed {}{}", kVersion, scene->name,
               to_text(invocation.config.speed),
               invocation.config.time.clients_pace ? ", virtual time" : "");
  Daemon daemon(invocation.config, std::move(scene), invocation.demo);
  return serve_until_signal(daemon, invocation, [&] { return daemon.makes_progress(); });
}

/// Absent where this program cannot read the run's configuration.
std::optional<modbus::ConveyorScaling> recorded_scaling(const v1::JournalHeader& header) {
  const auto config = read_config(header.configuration());
  if (!config) return std::nullopt;
  return scaling_of(config->modbus);
}

int serve_replay(const Invocation& invocation, const journal::RecordedRun& run,
                 const journal::ReplayPart& part) {
  block_signals();
  if (auto ok = raise_file_limit(needed_files(invocation.config, {})); !ok) {
    return refuse(ok.error().message);
  }
  const Logging logging(invocation.config.log_level);
  spdlog::info("aprsimd {}: replays run {} of scene {}", kVersion, run.header().run_id(),
               run.header().scene());
  for (const std::string& caution : run.cautions()) spdlog::warn("replay: {}", caution);
  ReplayDaemon daemon(invocation.config, run, part, invocation.replay_speed);
  return serve_until_signal(daemon, invocation, [] { return true; });
}

/// Refuses to write over a journal of the run.
Result<void> check_replay_outputs(const Invocation& invocation) {
  std::vector<std::string> inputs, outputs;
  for (const std::string& place : invocation.replay) {
    inputs.push_back(place);
    if (const auto files = aprsim::journal::files_of_run(place)) {
      inputs.insert(inputs.end(), files->begin(), files->end());
    }
  }
  for (const std::string& output :
       {invocation.motion.file, invocation.motion.video, invocation.ports_file}) {
    if (!output.empty()) outputs.push_back(output);
  }
  return files::check_outputs(inputs, outputs);
}

/// Exit code 1 when the replay differs, 2 when it fails.
int replay(const Invocation& invocation) {
  const auto unreadable = [](const Error& error) {
    refuse(error.message);
    return 2;
  };
  if (auto apart = check_replay_outputs(invocation); !apart) return unreadable(apart.error());
  const auto run = journal::RecordedRun::open(invocation.replay, kVersion);
  if (!run) return unreadable(run.error());
  journal::ReplayPart part = invocation.replay_part;
  part.scaling = recorded_scaling(run->header());
  if (invocation.serve_replay) return serve_replay(invocation, *run, part);
  if (invocation.exit_on_stdin_eof) process::stop_when_input_ends();
  if (invocation.replay_speed) part.watch = journal::paced(*invocation.replay_speed);
  std::optional<MotionFile> motion;
  std::optional<VideoFile> video;
  if (!invocation.motion.file.empty()) {
    motion.emplace(invocation.motion, run->header());
  }
  if (!invocation.motion.video.empty()) {
    const auto camera = camera_named(*run->scene(), invocation.motion.camera);
    if (!camera) return unreadable(camera.error());
    video.emplace(invocation.motion, run->scene()->cameras[*camera], run->header().seed());
  }
  if (motion || video) {
    part.watch = [&motion, &video, paced = part.watch](const world::World& world,
                                                       world::RunTime time) {
      if (motion) motion->sample(world, time);
      return (!video || video->sample(world, time)) && (!paced || paced(world, time));
    };
  }
  const auto result = journal::replay_run(*run, part);
  if (!result) return unreadable(result.error());
  if (motion) {
    if (auto written = motion->finish(); !written) return unreadable(written.error());
  }
  if (video) {
    if (auto written = video->finish(); !written) return unreadable(written.error());
  }
  std::cout << (invocation.json ? journal::json_of(*run, *result)
                                : journal::text_of(*run, *result));
  return result->same() ? EXIT_SUCCESS : EXIT_FAILURE;
}

/// Makes the directories of extensions known to all that builds scenes.
Result<void> use_extensions(const std::vector<std::string>& directories) {
  std::vector<std::string> all;
  for (const std::string& directory : directories) {
    std::error_code status;
    if (!std::filesystem::is_directory(directory, status)) {
      return fail(ErrorCode::kNotFound, "extensions",
                  "extensions: '" + directory + "' is no directory");
    }
    all.push_back(std::filesystem::absolute(directory, status).string());
  }
  scene::add_extension_directories(all);
  return {};
}

int start(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "token") {
    return token_command({argv + 2, argv + argc}, std::cout, std::cerr);
  }
  int exit_code = 0;
  const auto invocation = parse_command_line(argc, argv, exit_code);
  if (!invocation) return exit_code;
  if (invocation->print_config) {
    std::cout << to_yaml(invocation->config);
    return EXIT_SUCCESS;
  }
  if (invocation->list_keys) {
    std::cout << key_list(invocation->config);
    return EXIT_SUCCESS;
  }
  if (auto ok = use_extensions(invocation->config.extensions); !ok) {
    return refuse(ok.error().message);
  }
  if (!invocation->replay.empty()) return replay(*invocation);
  auto scene = scene::load_scene(invocation->config.scene, scene::default_data_paths());
  if (!scene) return refuse(scene.error().message);
  auto shared = std::make_shared<const scene::Scene>(std::move(*scene));
  warn_of_unknown_robots(invocation->config, *shared);
  if (auto ok = check_pacers(invocation->config.time, robots_of(*shared)); !ok) {
    return refuse(ok.error().message);
  }
  if (invocation->check_only) {
    Daemon::check(invocation->config, shared);
    std::cout << "scene " << shared->name << ": " << shared->robots.size() << " robots, "
              << shared->trays.size() << " trays, " << shared->gears.size() << " gears"
              << (shared->parts.empty() ? ""
                                        : ", " + std::to_string(shared->parts.size()) + " parts")
              << "; ok\n";
    return EXIT_SUCCESS;
  }
  return serve(*invocation, std::move(shared));
}

}  // namespace

int run(int argc, char** argv) {
  open_standard_descriptors();
  try {
    return check_output(start(argc, argv));
  } catch (const std::exception& failure) {
    return refuse(failure.what());
  }
}

}  // namespace aprsim::server
