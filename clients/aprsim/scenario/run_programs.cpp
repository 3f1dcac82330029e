#include "clients/aprsim/scenario/run_programs.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "clients/aprsim/cli/interruption.hpp"
#include "world/base/process/own_programs.hpp"

namespace aprsim::client {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using process::ChildProcess;

constexpr auto kKilledTime = 10s;  // for a killed program to be gone

Outcome<ChildProcess> start_daemon(const scenario::Plan& plan, const RunDirectory& directory,
                                   const DaemonOptions& options) {
  const std::string scene = directory.file("scene.yaml"), ports = directory.file("ports.json");
  std::error_code status;
  fs::remove(ports, status);
  if (std::ofstream file(scene); !(file << plan.scene_text << std::flush)) {
    return failed(FailureKind::kUsage, "cannot write " + scene);
  }
  std::vector<std::string> arguments{process::program_beside("aprsimd"),
                                     "--scene",
                                     scene,
                                     "--seed",
                                     std::to_string(plan.seed),
                                     "--any-port",
                                     "--no-web",
                                     "--ports-file",
                                     ports};
  // No incident is needed of a run that can be repeated.
  if (!options.pacers.empty()) {
    arguments.insert(arguments.end(),
                     {"--set", "journal.memory_mb=0", "--set", "history.minutes=0"});
  }
  const std::vector<std::string> pace =
      options.pacers.empty()
          ? std::vector<std::string>{"--speed", "stepped"}
          : std::vector<std::string>{"--time", "virtual", "--pacers", options.pacers};
  arguments.insert(arguments.end(), pace.begin(), pace.end());
  if (!options.journal.empty()) {
    arguments.insert(arguments.end(), {"--journal", options.journal});
  }
  auto daemon = ChildProcess::start(arguments, {{"APRSIM_TOKEN", ""}},
                                    directory.file("aprsimd.log"), ChildProcess::Pipes::kNone);
  if (!daemon) return failed(FailureKind::kUsage, daemon.error().message);
  const auto deadline = std::chrono::steady_clock::now() + options.patience;
  while (!fs::exists(ports, status)) {
    if (interruption::requested()) return failed(FailureKind::kInterrupted, "interrupted");
    const std::string log = directory.file("aprsimd.log");
    if (const auto code = daemon->ended()) {
      return failed(
          FailureKind::kCheck,
          fmt::format("the daemon ended with {} before it served; {}", *code, log_end(log)));
    }
    if (std::chrono::steady_clock::now() > deadline) {
      return failed(FailureKind::kCheck, fmt::format("waited {} s for the daemon to serve; {}",
                                                     options.patience.count(), log_end(log)));
    }
    interruption::sleep_until(std::chrono::steady_clock::now() + 5ms);
  }
  return std::move(*daemon);
}

}  // namespace

RunDirectory::RunDirectory(const std::string& kept) : kept_(!kept.empty()) {
  std::error_code status;
  if (kept_) {
    fs::create_directories(kept, status);
    path_ = kept;
    return;
  }
  std::string name = (fs::temp_directory_path(status) / "aprsim-run-XXXXXX").string();
  if (mkdtemp(name.data()) != nullptr) path_ = name;
}

RunDirectory::~RunDirectory() {
  std::error_code ignored;
  if (!kept_ && !path_.empty()) fs::remove_all(path_, ignored);
}

std::vector<std::string> RunDirectory::files(const std::string& directory) {
  std::vector<std::string> out;
  for (const char* name :
       {"scene.yaml", "ports.json", "aprsimd.log", "controller.log", "controller.out"}) {
    out.push_back((fs::path(directory) / name).string());
  }
  return out;
}

std::string log_end(const std::string& file) {
  const std::string name = fs::path(file).filename().string();
  std::ifstream in(file);
  std::string text, line;
  while (std::getline(in, line)) {
    text += line + '\n';
    if (text.size() > 2000) text.erase(0, text.size() - 2000);
  }
  return text.empty() ? name + " is empty" : "the end of " + name + ":\n" + text;
}

std::vector<std::string> robots_of(const scenario::Scenario& scenario, const scene::Scene& scene) {
  std::vector<std::string> robots;
  const auto& options = scenario.controller_options;
  const auto chosen = std::ranges::find(options, "--robots");
  if (chosen != options.end() && chosen + 1 != options.end()) {
    std::istringstream names(*(chosen + 1));
    for (std::string name; std::getline(names, name, ',');) robots.push_back(name);
    return robots;
  }
  for (const auto& robot : scene.robots) robots.push_back(robot.name);
  return robots;
}

std::vector<std::string> roles_of(const scenario::Scenario& scenario,
                                  const std::vector<std::string>& robots, bool uses_vision) {
  // The kitting controller polls the gripper's port where it uses the wires of ROS 2.
  const bool simple_message = std::ranges::find(scenario.controller_options, "simple-message") !=
                              scenario.controller_options.end();
  std::vector<std::string> out;
  for (const std::string& robot : robots) {
    out.push_back((simple_message ? "gripper." : "crcl.") + robot);
    if (uses_vision) out.push_back("vision." + robot);
  }
  return out;
}

std::string pacers_of(const std::vector<std::string>& roles) {
  std::string out = "grpc";
  for (const std::string& role : roles) out += ',' + role;
  return out;
}

Outcome<Place> own_place(const scenario::Plan& plan, const RunDirectory& directory,
                         const DaemonOptions& options) {
  auto daemon = start_daemon(plan, directory, options);
  if (!daemon) return tl::unexpected(daemon.error());
  Place place{.ports_file = directory.file("ports.json")};
  place.daemon.emplace(std::move(*daemon));
  auto endpoints = read_ports_file(place.ports_file);
  if (!endpoints) return tl::unexpected(endpoints.error());
  place.endpoints = std::move(*endpoints);
  return place;
}

std::vector<std::string> controller_command(const scenario::Scenario& scenario,
                                            const ControllerOptions& options, const Place& place) {
  if (!options.command.empty()) return {"/bin/sh", "-c", options.command};
  std::vector<std::string> out = {"python3",   process::kitting_program(scenario.program),
                                  "--cell",    scenario.cell,
                                  "--host",    place.endpoints.host,
                                  "--order",   "-",
                                  "--poll-ms", fmt::format("{}", options.poll_ms)};
  if (!place.ports_file.empty()) {
    out.insert(out.end(), {"--ports-file", place.ports_file});
  }
  if (options.polls_are_clock) out.insert(out.end(), {"--clock", "polls"});
  if (options.reuse_controller) out.emplace_back("--reuse-controller");
  out.insert(out.end(), scenario.controller_options.begin(), scenario.controller_options.end());
  return out;
}

Outcome<void> Controller::start() {
  process_.reset();
  const std::string log =
      ++starts_ == 1 ? "controller.log" : fmt::format("controller_{}.log", starts_);
  auto started = ChildProcess::start(command_, {{"APRSIM_PORTS_FILE", ports_file_}},
                                     directory_.file(log), ChildProcess::Pipes::kInputAndOutput);
  if (!started) return failed(FailureKind::kUsage, started.error().message);
  process_.emplace(std::move(*started));
  return {};
}

void Controller::kill() {
  process_->signal(SIGKILL);
  static_cast<void>(process_->wait(kKilledTime));
}

}  // namespace aprsim::client
