#include "clients/aprsim/scenario/station.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/scenario/run_programs.hpp"
#include "clients/aprsim/scenario/run_watch.hpp"
#include "clients/aprsim/scenario/sampler.hpp"
#include "clients/wires/cell_connection.hpp"
#include "clients/wires/interruption.hpp"

namespace aprsim::client {
namespace {

using namespace std::chrono_literals;
using process::ChildProcess;

constexpr std::uint64_t kVirtualSteps = 25;  // from sample to sample, as of polls
constexpr auto kReadyTime = 30s;             // for a controller to connect
constexpr auto kAloneTime = 20s;             // for the connections of a killed one to end
constexpr auto kStandstill = 120s;           // without any simulated time
constexpr auto kProgramEnd = 10s;            // for a program to end when it is told to

Failure not_going_on(const std::string& what) {
  return {FailureKind::kCheck, "time stands: " + what};
}

/// Virtual time, from sample to sample.
class SampleTime {
 public:
  SampleTime(CellConnection& cell, RunWatch& watch) : cell_(cell), watch_(watch) {}

  /// The cell at the next sample; none when the controller does nothing more, or the user has had
  /// enough. Failure: nothing happens for long, or the controller does not end after the run.
  Outcome<std::optional<v1::Snapshot>> pass(bool over) {
    const auto now = std::chrono::steady_clock::now();
    if (over && !home_by_) home_by_ = now + kStandstill;
    const auto deadline = home_by_.value_or(now + kStandstill);
    bool late = false;
    const auto waits = [&] {
      late = std::chrono::steady_clock::now() > deadline;
      if (over) watch_.listen();
      return !late && !interruption::noted() && !watch_.prick_up() &&
             !(over && watch_.controller_has_ended());
    };
    // Only one may ask at once: what was asked for before comes first.
    while (goal_) {
      auto snapshot = look();
      if (!snapshot) return tl::unexpected(snapshot.error());
      if (!goal_) return std::optional(std::move(*snapshot));
      if (!waits()) break;
      interruption::sleep_until(std::chrono::steady_clock::now() + 2ms);
    }
    Outcome<std::optional<v1::Snapshot>> passed;
    // What nobody else paces answers before anything could be heard while it is waited for.
    const bool has_ended = over && !waits();
    if (!goal_ && !has_ended) passed = cell_.step_and_look(kVirtualSteps, kSampledFields, waits);
    if (late && over)
      return failed(FailureKind::kCheck, "the controller does not end after the run");
    if (late) return tl::unexpected(not_going_on("the controller neither polls nor ends"));
    return passed;
  }

  /// Lets the CRCL connections of a controller that is gone end, each at the time of its last poll.
  /// Time then stands until another controller is there. A camera's feed notices at its next frame.
  Outcome<void> pass_until_alone(std::uint64_t now, const std::vector<std::string>& roles) {
    const auto deadline = std::chrono::steady_clock::now() + kAloneTime;
    while (std::chrono::steady_clock::now() < deadline && !interruption::noted()) {
      if (const auto asked = ask(now, 50ms); !asked) return tl::unexpected(asked.error());
      const auto snapshot = look();
      if (!snapshot) return tl::unexpected(snapshot.error());
      now = snapshot->step();
      const auto& awaited = snapshot->virtual_time().awaited();
      const auto is_awaited = [&](const std::string& role) {
        return !role.starts_with("crcl.") || std::ranges::find(awaited, role) != awaited.end();
      };
      if (std::ranges::all_of(roles, is_awaited)) return {};
      interruption::sleep_until(std::chrono::steady_clock::now() + 5ms);
    }
    return failed(FailureKind::kCheck, "the killed controller's connections do not end");
  }

 private:
  /// For the steps of a sample, if none are asked for: the cell after them, when they have passed
  /// in time.
  Outcome<std::optional<v1::Snapshot>> ask(std::uint64_t now, std::chrono::milliseconds patience) {
    if (goal_) return std::nullopt;
    auto passed = cell_.step_and_look(kVirtualSteps, kSampledFields, patience);
    if (passed) return std::move(*passed);
    if (passed.error().kind != FailureKind::kTimeout) return tl::unexpected(passed.error());
    goal_ = now + kVirtualSteps;
    return std::nullopt;
  }

  /// The cell as it is, and whether it has got to where it was asked to.
  Outcome<v1::Snapshot> look() {
    auto snapshot = cell_.snapshot();
    if (!snapshot || !goal_) return snapshot;
    if (snapshot->step() >= *goal_) {
      goal_.reset();
    } else if (std::ranges::count(snapshot->virtual_time().awaited(), "grpc") > 0) {
      return ask_again(std::move(*snapshot));
    }
    return snapshot;
  }

  /// Time stands until it is asked for: the last request was given up before the cell heard of it.
  Outcome<v1::Snapshot> ask_again(v1::Snapshot now) {
    goal_.reset();
    auto passed = ask(now.step(), 50ms);
    if (!passed) {
      // Or it has been heard of since, and only one may ask at once.
      if (passed.error().kind != FailureKind::kRefused) return tl::unexpected(passed.error());
      goal_ = now.step() + kVirtualSteps;
    }
    return passed && *passed ? std::move(**passed) : std::move(now);
  }

  CellConnection& cell_;
  RunWatch& watch_;
  /// Of a run that is over: when its controller is to have ended.
  std::optional<std::chrono::steady_clock::time_point> home_by_;
  std::optional<std::uint64_t> goal_;  ///< step that has been asked for and not been reached
};

/// Greatest resident memory of a process so far [bytes].
std::uint64_t peak_of(pid_t pid) {
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;
  }
  return 0;
}

}  // namespace

struct Station::Programs {
  explicit Programs(const std::string& kept) : directory(kept) {}

  RunDirectory directory;
  std::vector<std::string> roles;
  std::optional<Place> place;
  std::optional<CellConnection> cell;
  std::optional<Controller> controller;
};

Station::Station(const scenario::Scenario& scenario, StationOptions options)
    : scenario_(scenario),
      options_(std::move(options)),
      again_(options_.controller.empty() || options_.again) {}

Station::~Station() { end_programs(); }

std::optional<pid_t> Station::daemon() const {
  if (!programs_ || !programs_->place) return std::nullopt;
  return programs_->place->daemon->pid();
}

Outcome<RunResult> Station::run(const scenario::Plan& plan, const RunListener& listener) {
  const interruption::Hold hold;
  auto result = run_once(plan, listener);
  if (result && programs_) return result;
  std::string log;
  if (!result && programs_) log = last_lines(programs_->directory.file("aprsimd.log"));
  end_programs();
  if (interruption::happened()) return failed(FailureKind::kInterrupted, "interrupted");
  if (!result && !log.empty()) result.error().message += "; " + log;
  return result;
}

Outcome<void> Station::start(const scenario::Plan& plan) {
  programs_ = std::make_unique<Programs>(options_.directory);
  ++starts_;
  Programs& programs = *programs_;
  programs.roles = roles_of(robots_of(scenario_, plan.scene), options_.controller.empty());
  auto place = own_place(plan, programs.directory,
                         {.pacers = pacers_of(programs.roles), .journal = options_.journal});
  if (!place) return tl::unexpected(place.error());
  programs.place.emplace(std::move(*place));
  programs.cell.emplace(programs.place->endpoints);
  programs.controller.emplace(
      controller_command(scenario_,
                         {.command = options_.controller, .polls_are_clock = true, .again = again_},
                         *programs.place),
      programs.place->ports_file, programs.directory);
  if (!again_) return {};
  if (auto started = programs.controller->start(); !started) return started;
  // All connections are there before the first reset, as before all later ones.
  ChildProcess& controller = programs.controller->process();
  const auto deadline = std::chrono::steady_clock::now() + kReadyTime;
  while (std::chrono::steady_clock::now() < deadline && !interruption::noted()) {
    for (const std::string& line : controller.lines()) {
      if (event_of(line) == "ready") return {};
    }
    if (controller.ended()) break;
    static_cast<void>(controller.wait(2ms));
  }
  return failed(FailureKind::kCheck, "the controller does not get ready: " +
                                         last_lines(programs.directory.file("controller.log")));
}

Outcome<RunResult> Station::run_once(const scenario::Plan& plan, const RunListener& listener) {
  if (!programs_) {
    if (auto started = start(plan); !started) return tl::unexpected(started.error());
  }
  Programs& programs = *programs_;
  CellConnection& cell = *programs.cell;
  Controller& controller = *programs.controller;
  v1::ResetRequest again;
  again.set_seed(plan.seed);
  again.set_scene_text(plan.scene_text);
  for (const auto& done : {cell.reset(again), cell.resume()}) {
    if (!done) return tl::unexpected(done.error());
  }
  auto description = cell.cell();
  if (!description) return tl::unexpected(description.error());
  if (again_) {
    controller.process().write_line(nlohmann::json{{"begin", plan.seed}}.dump());
  } else if (auto started = controller.start(); !started) {
    return tl::unexpected(started.error());
  }
  std::ofstream heard(programs.directory.file("controller.out"));
  RunWatch watch(scenario_, plan, cell, std::move(*description), &controller.process(),
                 options_.controller.empty(), heard, listener);
  if (auto injected = watch.inject(); !injected) return tl::unexpected(injected.error());

  std::string hash;
  SampleTime time(cell, watch);
  auto snapshot = cell.snapshot();
  for (bool over = false; snapshot;) {
    if (!over && !watch.take(*snapshot)) {
      over = true;
      // Time stands: this is the same state.
      const auto whole = cell.snapshot();
      if (!whole) return tl::unexpected(whole.error());
      hash = fmt::format("{:016x}", whole->state_hash());
      if (!watch.all_submitted()) break;
      // It is to go home, which others may still have to see.
      if (again_) {
        controller.process().write_line(R"({"end": true})");
      } else {
        controller.process().close_input();
      }
      watch.expect_answer();
    } else if (!over && watch.kill_is_due()) {
      controller.kill();
      watch.controller_killed(*snapshot);
      if (auto alone = time.pass_until_alone(snapshot->step(), programs.roles); !alone) {
        return tl::unexpected(alone.error());
      }
      if (auto started = controller.start(); !started) return tl::unexpected(started.error());
      if (again_) {
        controller.process().write_line(nlohmann::json{{"begin", plan.seed}}.dump());
      }
      watch.controller_started(controller.process());
      snapshot = cell.snapshot();
      continue;
    }
    watch.await_answers();
    auto passed = time.pass(over);
    if (!passed) return tl::unexpected(passed.error());
    if (interruption::noted()) return failed(FailureKind::kInterrupted, "interrupted");
    if (*passed) {
      snapshot = std::move(**passed);
      continue;
    }
    // The controller does nothing more: time stands, beyond the last sample or not.
    if (over) break;
    snapshot = cell.snapshot();
    if (!snapshot) break;
    if (snapshot->step() == watch.last_step() || watch.take(*snapshot)) {
      watch.end_with_controller();
    }
    hash = fmt::format("{:016x}", snapshot->state_hash());
    break;
  }
  if (!snapshot) return tl::unexpected(snapshot.error());
  if (interruption::noted()) return failed(FailureKind::kInterrupted, "interrupted");
  const auto exit_code = controller.process().ended();
  if (exit_code && *exit_code < 0) {
    return failed(FailureKind::kCheck,
                  fmt::format("the controller died of signal {}", -*exit_code));
  }
  RunResult result = watch.result();
  result.state_hash = hash;
  result.controller = options_.controller.empty() ? scenario_.program : options_.controller;

  // Another run can follow once the controller polls no more.
  bool ready = again_ && watch.ended_in_order() && !exit_code && cell.pause();
  const auto deadline = std::chrono::steady_clock::now() + kProgramEnd;
  while (ready && !watch.controller_is_ready()) {
    watch.listen();
    if (watch.controller_is_ready()) break;
    ready = !controller.process().wait(1ms) && std::chrono::steady_clock::now() < deadline;
  }
  if (const auto pid = daemon()) peak_bytes_ = std::max(peak_bytes_, peak_of(*pid));
  if (!ready) end_programs();
  return result;
}

void Station::end_programs() {
  if (!programs_) return;
  const interruption::Cleanup cleanup;
  if (programs_->controller && programs_->controller->is_there()) {
    ChildProcess& controller = programs_->controller->process();
    controller.close_input();
    // One that waits for orders ends at once.
    if (!controller.wait(200ms)) controller.stop(kProgramEnd);
  }
  // A daemon ends at once when nobody is connected.
  programs_->cell.reset();
  if (programs_->place) programs_->place->daemon->stop(kProgramEnd);
  programs_.reset();
}

}  // namespace aprsim::client
