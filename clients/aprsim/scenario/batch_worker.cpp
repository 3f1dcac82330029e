#include "clients/aprsim/scenario/batch_worker.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/scenario/run_programs.hpp"
#include "clients/aprsim/scenario/run_watch.hpp"
#include "clients/aprsim/scenario/sample_time.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {
namespace {

using namespace std::chrono_literals;
using process::ChildProcess;

// Time for a program to end or to become ready for the next run. A slower one is killed or
// restarted; results do not depend on it.
constexpr auto kProgramEnd = 10s;

/// Greatest resident memory of a process so far [bytes].
std::uint64_t peak_of(pid_t pid) {
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;
  }
  return 0;
}

std::string hash_of(const v1::Snapshot& snapshot) {
  return fmt::format("{:016x}", snapshot.state_hash());
}

}  // namespace

struct BatchWorker::Programs {
  explicit Programs(const std::string& kept) : directory(kept) {}

  RunDirectory directory;
  std::vector<std::string> roles;
  std::optional<Place> place;
  std::optional<CellConnection> cell;
  std::optional<Controller> controller;
};

BatchWorker::BatchWorker(const scenario::Scenario& scenario, BatchWorkerOptions options)
    : scenario_(scenario),
      options_(std::move(options)),
      reuse_controller_(options_.controller.empty() || options_.reuse_controller) {}

BatchWorker::~BatchWorker() { end_programs(); }

std::optional<pid_t> BatchWorker::daemon() const {
  if (!programs_ || !programs_->place) return std::nullopt;
  return programs_->place->daemon->pid();
}

Outcome<RunResult> BatchWorker::run(const scenario::Plan& plan, const RunListener& listener) {
  const interruption::Hold hold;
  auto result = run_once(plan, listener);
  if (result && programs_) return result;
  std::string log;
  if (!result && programs_) log = log_end(programs_->directory.file("aprsimd.log"));
  end_programs();
  if (interruption::happened()) return failed(FailureKind::kInterrupted, "interrupted");
  if (!result && !log.empty()) result.error().message += "; " + log;
  return result;
}

Outcome<void> BatchWorker::start(const scenario::Plan& plan) {
  programs_ = std::make_unique<Programs>(options_.directory);
  ++starts_;
  Programs& programs = *programs_;
  programs.roles =
      roles_of(scenario_, robots_of(scenario_, plan.scene), options_.controller.empty());
  auto place = own_place(plan, programs.directory,
                         {.pacers = pacers_of(programs.roles),
                          .journal = options_.journal,
                          .patience = options_.patience});
  if (!place) return tl::unexpected(place.error());
  programs.place.emplace(std::move(*place));
  programs.cell.emplace(programs.place->endpoints, options_.patience);
  programs.controller.emplace(controller_command(scenario_,
                                                 {.command = options_.controller,
                                                  .polls_are_clock = true,
                                                  .reuse_controller = reuse_controller_},
                                                 *programs.place),
                              programs.place->ports_file, programs.directory);
  if (!reuse_controller_) return {};
  if (auto started = programs.controller->start(); !started) return started;
  return await_ready();
}

Outcome<void> BatchWorker::await_ready() {
  // All connections are open before the first reset, as before all later ones.
  ChildProcess& controller = programs_->controller->process();
  const auto deadline = std::chrono::steady_clock::now() + options_.patience;
  std::string why;
  while (!interruption::requested()) {
    const auto code = controller.ended();
    for (const std::string& line : controller.lines()) {
      if (event_of(line) == "ready") return {};
    }
    if (code) why = fmt::format("the controller ended with {} before it was ready", *code);
    if (std::chrono::steady_clock::now() > deadline) {
      why =
          fmt::format("waited {} s for the controller to report ready", options_.patience.count());
    }
    if (!why.empty()) break;
    static_cast<void>(controller.wait(2ms));
  }
  if (why.empty()) return failed(FailureKind::kInterrupted, "interrupted");
  return failed(FailureKind::kCheck,
                why + "; " + log_end(programs_->directory.file("controller.log")));
}

Outcome<RunResult> BatchWorker::run_once(const scenario::Plan& plan, const RunListener& listener) {
  if (!programs_) {
    if (auto started = start(plan); !started) return tl::unexpected(started.error());
  }
  Programs& programs = *programs_;
  auto description = begin(plan);
  if (!description) return tl::unexpected(description.error());
  ChildProcess& controller = programs.controller->process();
  std::ofstream heard(programs.directory.file("controller.out"));
  RunWatch watch(scenario_, plan, *programs.cell, std::move(*description), &controller,
                 options_.controller.empty(), heard, listener);
  if (auto injected = watch.inject(); !injected) return tl::unexpected(injected.error());
  const auto hash = pass_time(plan.seed, watch);
  if (!hash) return tl::unexpected(hash.error());
  if (interruption::requested()) return failed(FailureKind::kInterrupted, "interrupted");
  if (const int code = programs.controller->process().ended().value_or(0); code < 0) {
    return failed(FailureKind::kCheck, fmt::format("the controller died of signal {}", -code));
  }
  RunResult result = watch.result();
  result.state_hash = *hash;
  result.controller = options_.controller.empty() ? scenario_.program : options_.controller;
  const bool ready = gets_ready(watch);
  if (const auto pid = daemon()) peak_bytes_ = std::max(peak_bytes_, peak_of(*pid));
  if (!ready) end_programs();
  return result;
}

Outcome<v1::CellDescription> BatchWorker::begin(const scenario::Plan& plan) {
  CellConnection& cell = *programs_->cell;
  v1::ResetRequest reset;
  reset.set_seed(plan.seed);
  reset.set_scene_text(plan.scene_text);
  for (const auto& done : {cell.reset(reset), cell.resume()}) {
    if (!done) return tl::unexpected(done.error());
  }
  auto description = cell.cell();
  if (!description) return description;
  if (reuse_controller_) {
    begin_job(plan.seed);
  } else if (auto started = programs_->controller->start(); !started) {
    return tl::unexpected(started.error());
  }
  return description;
}

void BatchWorker::begin_job(std::uint64_t seed) {
  programs_->controller->process().write_line(nlohmann::json{{"begin", seed}}.dump());
}

void BatchWorker::end_job() {
  ChildProcess& controller = programs_->controller->process();
  if (reuse_controller_) {
    controller.write_line(R"({"end": true})");
  } else {
    controller.close_input();
  }
}

Outcome<std::string> BatchWorker::pass_time(std::uint64_t seed, RunWatch& watch) {
  CellConnection& cell = *programs_->cell;
  SampleTime time(cell, watch, options_.patience);
  std::string hash;
  auto snapshot = cell.snapshot();
  for (bool over = false; snapshot;) {
    if (!over && !watch.accept(*snapshot)) {
      over = true;
      // Time has not advanced: this is the same state.
      const auto whole = cell.snapshot();
      if (!whole) return tl::unexpected(whole.error());
      hash = hash_of(*whole);
      if (!watch.all_submitted()) return hash;
      // The robot returns home, which others may still have to see.
      end_job();
      watch.expect_answer();
    } else if (!over && watch.kill_is_due()) {
      if (auto done = replace_controller(*snapshot, seed, time, watch); !done) {
        return tl::unexpected(done.error());
      }
      snapshot = cell.snapshot();
      continue;
    }
    if (auto answered = watch.await_answers(options_.patience); !answered) {
      return tl::unexpected(answered.error());
    }
    auto passed = time.pass(over);
    if (!passed) return tl::unexpected(passed.error());
    if (interruption::requested()) return failed(FailureKind::kInterrupted, "interrupted");
    if (*passed) {
      snapshot = std::move(**passed);
      continue;
    }
    // The controller has finished: time does not advance, whether beyond the last sample or not.
    if (over) return hash;
    snapshot = cell.snapshot();
    if (!snapshot) break;
    if (snapshot->step() == watch.last_step() || watch.accept(*snapshot)) {
      watch.end_with_controller();
    }
    return hash_of(*snapshot);
  }
  return tl::unexpected(snapshot.error());
}

Outcome<void> BatchWorker::replace_controller(const v1::Snapshot& now, std::uint64_t seed,
                                              SampleTime& time, RunWatch& watch) {
  Controller& controller = *programs_->controller;
  controller.kill();
  watch.controller_killed(now);
  if (auto alone = time.pass_until_alone(now.step(), programs_->roles); !alone) return alone;
  if (auto started = controller.start(); !started) return started;
  if (reuse_controller_) begin_job(seed);
  watch.controller_started(controller.process());
  return {};
}

bool BatchWorker::gets_ready(RunWatch& watch) {
  ChildProcess& controller = programs_->controller->process();
  if (!reuse_controller_ || !watch.ended_in_order() || controller.ended()) return false;
  if (!programs_->cell->pause()) return false;
  const auto deadline = std::chrono::steady_clock::now() + kProgramEnd;
  while (!watch.controller_is_ready()) {
    watch.listen();
    if (watch.controller_is_ready()) break;
    if (controller.wait(1ms) || std::chrono::steady_clock::now() >= deadline) return false;
  }
  return true;
}

void BatchWorker::end_programs() {
  if (!programs_) return;
  const interruption::Cleanup cleanup;
  if (programs_->controller && programs_->controller->is_there()) {
    ChildProcess& controller = programs_->controller->process();
    controller.close_input();
    // A controller that waits for orders ends at once.
    if (!controller.wait(200ms)) controller.stop(kProgramEnd);
  }
  // A daemon ends at once when nobody is connected.
  programs_->cell.reset();
  if (programs_->place) programs_->place->daemon->stop(kProgramEnd);
  programs_.reset();
}

}  // namespace aprsim::client
