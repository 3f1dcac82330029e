#include "server/programs/programs.hpp"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <utility>

#include <spdlog/spdlog.h>

#include "protocols/net/limited_log.hpp"
#include "server/programs/program_output.hpp"
#include "world/base/process/child_process.hpp"
#include "world/base/process/own_programs.hpp"
#include "world/scenario/scenario_reader.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {
namespace {

namespace fs = std::filesystem;
using process::ChildProcess;
using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPollPeriod{50};
constexpr const char* kSeedOption = "--seed";
constexpr std::size_t kBytesPerPoll = std::size_t{16} << 10;  // a flood waits in its pipe
void remove_file(const std::string& file) {
  std::error_code ignored;
  if (!file.empty()) fs::remove(file, ignored);
}

/// Describes how a program has ended.
std::string end_of(int code, bool was_stopped, bool killed) {
  if (killed) return "killed: it did not end on SIGTERM";
  if (was_stopped) return "stopped";
  if (code == 0) return "done";
  if (code < 0) return "ended by signal " + std::to_string(-code);
  return "ended with " + std::to_string(code);
}

}  // namespace

/// A running program.
struct Programs::Child {
  ChildProcess process;
  web::ProgramStatus status;
  protocols::LimitedLog log;
  std::optional<SteadyClock::time_point> kill_at = {};
  bool killed = false;
};

Programs::Programs(ProgramsOptions options)
    : options_(std::move(options)), programs_(options_.programs) {
  publish({});
  thread_ = std::jthread([this] { run(); });
}

Programs::~Programs() { close(); }

void Programs::close() {
  const std::lock_guard lock(mutex_);
  closed_ = stop_wanted_ = true;
  if (wanted_) remove_file(wanted_->file);
  wanted_.reset();
  changed_.notify_all();
}

void Programs::offer(std::vector<Program> programs) {
  const std::lock_guard lock(mutex_);
  programs_ = std::move(programs);
  auto next = std::make_shared<web::ProgramStatus>(*status_);
  write_offers(*next);
  status_ = std::move(next);
}

/// Call it with the mutex locked.
void Programs::write_offers(web::ProgramStatus& status) const {
  status.offers.clear();
  for (const Program& program : programs_) status.offers.push_back(program.offer);
  status.refusal = options_.refusal;
  if (status.offers.empty() && status.refusal.empty()) {
    status.refusal = "No program is known for this scene.";
  }
}

/// Call it with the mutex locked.
const Program* Programs::find(const std::string& name) const {
  const auto found =
      std::ranges::find(programs_, name, [](const Program& program) { return program.offer.name; });
  return found == programs_.end() ? nullptr : &*found;
}

Result<void> Programs::start(const std::string& name, std::optional<std::uint64_t> seed) {
  if (!options_.refusal.empty()) {
    return fail(ErrorCode::kFailedPrecondition, "programs", options_.refusal);
  }
  return launch(name, seed);
}

Result<void> Programs::launch(const std::string& name, std::optional<std::uint64_t> seed) {
  const std::lock_guard lock(mutex_);
  const Program* program = find(name);
  if (program == nullptr) {
    return fail(
        ErrorCode::kNotFound, "name",
        '\'' + protocols::log_text(name, 64) + "' is not a program that can be started here");
  }
  if (seed && program->seed_option.empty()) {
    return fail(ErrorCode::kInvalidArgument, "seed", name + " takes no seed");
  }
  Start start{program->command};
  if (seed) {
    start.command.insert(start.command.end(), {program->seed_option, std::to_string(*seed)});
  }
  if (auto ready = check_free(); !ready) return ready;
  begin(name, std::move(start));
  return {};
}

Result<void> Programs::start_scenario(const std::string& name, const std::string& text,
                                      std::optional<std::uint64_t> seed) {
  if (!options_.refusal.empty() || options_.scenario_command.empty()) {
    return fail(ErrorCode::kFailedPrecondition, "programs",
                options_.refusal.empty() ? "No scenario can be run here." : options_.refusal);
  }
  const std::lock_guard lock(mutex_);
  if (auto ready = check_free(); !ready) return ready;
  const std::string file = options_.directory + "/" + name + ".yaml";
  if (std::ofstream out(file); !(out << text << std::flush)) {
    remove_file(file);
    return fail(ErrorCode::kUnavailable, "text", "cannot write " + file);
  }
  Start start{options_.scenario_command, file};
  start.command.push_back(file);
  if (seed) start.command.insert(start.command.end(), {kSeedOption, std::to_string(*seed)});
  begin(name, std::move(start));
  return {};
}

/// Call it with the mutex locked.
Result<void> Programs::check_free() const {
  if (closed_) return fail(ErrorCode::kUnavailable, "name", "the daemon is stopping");
  if (!busy_) return {};
  return fail(ErrorCode::kFailedPrecondition, "name", status_->name + " runs; stop it first");
}

/// Call it with the mutex locked.
void Programs::begin(const std::string& name, Start start) {
  wanted_ = std::move(start);
  busy_ = true;
  stop_wanted_ = false;
  auto starting = std::make_shared<web::ProgramStatus>();
  starting->offers = status_->offers;
  starting->refusal = status_->refusal;
  starting->name = name;
  starting->running = true;
  status_ = std::move(starting);
  changed_.notify_all();
}

Result<void> Programs::stop() {
  if (!options_.refusal.empty()) {
    return fail(ErrorCode::kFailedPrecondition, "programs", options_.refusal);
  }
  const std::lock_guard lock(mutex_);
  if (!busy_) return fail(ErrorCode::kFailedPrecondition, "name", "no program runs");
  stop_wanted_ = true;
  changed_.notify_all();
  return {};
}

std::shared_ptr<const web::ProgramStatus> Programs::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void Programs::publish(web::ProgramStatus status) {
  const std::lock_guard lock(mutex_);
  write_offers(status);
  status_ = std::make_shared<const web::ProgramStatus>(std::move(status));
}

void Programs::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return wanted_.has_value() || closed_; });
    if (!wanted_) return;
    const Start start = *std::exchange(wanted_, std::nullopt);
    web::ProgramStatus status = *status_;
    lock.unlock();
    auto process = ChildProcess::start(start.command,
                                       {options_.environment.begin(), options_.environment.end()},
                                       "", ChildProcess::Pipes::kOutputAndErrors);
    if (process) {
      spdlog::info("programs: {} started", status.name);
      Child child{.process = std::move(*process),
                  .status = std::move(status),
                  .log = protocols::LimitedLog("programs")};
      serve(child);
      status = std::move(child.status);
    } else {
      status.failed = true;
      status.end_reason = process.error().message;
    }
    remove_file(start.file);
    status.running = status.stopping = false;
    if (status.failed) {
      spdlog::warn("programs: {}: {}", status.name, status.end_reason);
    } else {
      spdlog::info("programs: {}: {}", status.name, status.end_reason);
    }
    lock.lock();
    write_offers(status);
    status_ = std::make_shared<const web::ProgramStatus>(std::move(status));
    busy_ = false;
  }
}

/// Reads its output until it has ended.
void Programs::serve(Child& child) {
  web::ProgramStatus& status = child.status;
  std::optional<int> code;
  while (true) {
    // Queried first, so that all output before the end is read.
    code = child.process.ended();
    const auto lines = code ? child.process.lines() : child.process.lines(kBytesPerPoll);
    for (const std::string& line : lines) {
      if (const auto text = take_line(line, status)) child.log.warn(status.name + ": " + *text);
    }
    if (!lines.empty()) publish(status);
    if (code) break;
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kPollPeriod, [&] { return stop_wanted_ && !status.stopping; });
    const bool closing = closed_;
    if (stop_wanted_ && !status.stopping) {
      lock.unlock();
      status.stopping = true;
      publish(status);
      child.process.signal(SIGTERM);
      child.kill_at = SteadyClock::now() + options_.patience;
    }
    if (closing && child.kill_at) {
      child.kill_at = std::min(*child.kill_at, SteadyClock::now() + options_.last_patience);
    }
    if (child.kill_at && !child.killed && SteadyClock::now() >= *child.kill_at) {
      child.process.signal(SIGKILL);
      child.killed = true;
    }
  }
  status.failed = child.killed || (*code != 0 && !status.stopping);
  status.end_reason = end_of(*code, status.stopping, child.killed);
}

std::vector<std::string> scenario_command(const std::string& host, const std::string& ports_file) {
  return {process::program_beside("aprsim"),
          "--ports-file",
          ports_file,
          "--host",
          host,
          "scenario",
          "run",
          "--attach",
          "--progress"};
}

std::vector<Program> known_programs(const std::string& scene, const std::string& host,
                                    const std::string& ports_file) {
  std::vector<Program> all;
  const auto paths = scene::default_data_paths();
  const auto file = scene::find_scene(scene, paths);
  if (!file) return all;
  std::error_code status;
  const fs::path kitting = process::kitting_program();
  const std::string cell = fs::path(*file).stem().string();
  const bool shipped = fs::equivalent(fs::path(*file).parent_path(), paths.scenes, status);
  if (shipped && fs::is_regular_file(kitting.parent_path() / "cells" / (cell + ".toml"), status)) {
    all.push_back({{kDemo, "The kitting controller fills and empties kits until it is stopped"},
                   {"python3", kitting.string(), "--cell", cell, "--host", host, "--ports-file",
                    ports_file, "--forever", "--json"},
                   ""});
  }
  for (const std::string& name : scene::names_in(paths.scenarios)) {
    const auto summary = scenario::summarize_scenario(name, paths);
    // `aprsim scenario` reports a scenario that cannot be read.
    if (!summary || summary->changes_parts) continue;
    if (!fs::equivalent(summary->scene_file, *file, status)) continue;
    std::vector<std::string> command = scenario_command(host, ports_file);
    command.push_back(name);
    all.push_back({{name, summary->description, true}, std::move(command), kSeedOption});
  }
  return all;
}

}  // namespace aprsim::server
