#include "clients/aprsim/scenario/runner.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <utility>

#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/scenario/batch_worker.hpp"
#include "clients/aprsim/scenario/run_programs.hpp"
#include "clients/aprsim/scenario/run_watch.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {
namespace {

using namespace std::chrono_literals;
using process::ChildProcess;

constexpr double kSamplesPerSecond = 50;  // of simulated time, if the connection keeps up
constexpr double kMostSamplesPerSecond = 400;
constexpr const char* kNoController = "none";
constexpr auto kEndTime = 10s;   // for a program to end on request
constexpr auto kHomeTime = 30s;  // for a controller that has no more orders

/// Resets a running cell and pauses it.
Outcome<void> make_ready(const scenario::Scenario& scenario, const scenario::Plan& plan,
                         CellConnection& cell) {
  if (scenario.changes_parts) {
    return failed(FailureKind::kUsage,
                  scenario.file +
                      ": a running cell keeps its own parts, and this scenario "
                      "adds or removes parts");
  }
  const auto description = cell.cell();
  if (!description) return tl::unexpected(description.error());
  if (description->scene() != plan.scene.name) {
    return failed(FailureKind::kUsage, scenario.file + ": is for scene " + plan.scene.name +
                                           ", and the cell has scene " + description->scene());
  }
  if (const auto paused = cell.pause(); !paused) return tl::unexpected(paused.error());
  v1::ResetRequest again;
  again.set_seed(plan.seed);
  if (const auto reset = cell.reset(again); !reset) {
    static_cast<void>(cell.resume());
    return tl::unexpected(reset.error());
  }
  return {};
}

/// Takes samples as often as the wire allows until the run is over.
Outcome<void> watch_by_wall_clock(CellConnection& cell, RunWatch& run, Controller* controller,
                                  std::optional<double> speed) {
  for (const auto& done : {cell.set_speed(speed), cell.resume()}) {
    if (!done) return tl::unexpected(done.error());
  }
  const double rate_hz =
      std::min(kMostSamplesPerSecond,
               kSamplesPerSecond * std::max(1.0, speed.value_or(kMostSamplesPerSecond)));
  Outcome<void> restarted;
  const auto watched = cell.stream(rate_hz, [&](const v1::StreamSnapshotsResponse& sample) {
    if (!run.accept(sample.snapshot())) return false;
    if (run.kill_is_due()) {
      controller->kill();
      run.controller_killed(sample.snapshot());
      restarted = controller->start();
      if (restarted) run.controller_started(controller->process());
    }
    return restarted.has_value();
  });
  if (!restarted) return tl::unexpected(restarted.error());
  if (!watched) return tl::unexpected(watched.error());
  return {};
}

/// Waits for the controller to end by itself if it may, else requests its end.
void end_controller(ChildProcess& controller, RunWatch& run) {
  const interruption::Cleanup cleanup;
  controller.close_input();
  const auto deadline = std::chrono::steady_clock::now() + kHomeTime;
  while (run.all_submitted() && !controller.ended() &&
         std::chrono::steady_clock::now() < deadline) {
    run.listen();
    static_cast<void>(controller.wait(50ms));
  }
  if (!controller.ended()) controller.stop(kEndTime);
  run.listen();
}

Outcome<RunResult> run_in_virtual_time(const scenario::Scenario& scenario,
                                       const scenario::Plan& plan, const RunOptions& options,
                                       const RunListener& listener) {
  if (options.controller == kNoController || options.cell) {
    return failed(FailureKind::kUsage,
                  "in virtual time the cell and the controller are started by the run");
  }
  BatchWorker worker(scenario, {.controller = options.controller,
                                .directory = options.directory,
                                .journal = options.journal,
                                .patience = options.patience});
  return worker.run(plan, listener);
}

/// Ends the run's own daemon, or resumes an attached cell. Returns the result of the run, with
/// the log of its own daemon.
Outcome<void> leave(Place& place, std::optional<CellConnection>& connection, RunWatch& run,
                    const RunDirectory& directory, const Outcome<void>& watched) {
  const interruption::Cleanup cleanup;
  if (!place.daemon) {
    run.end_faults();
    if (!watched) static_cast<void>(connection->resume());
    return watched;
  }
  connection.reset();
  place.daemon->stop(kEndTime);
  if (watched) return watched;
  return failed(watched.error().kind,
                watched.error().message + "; " + log_end(directory.file("aprsimd.log")));
}

}  // namespace

Outcome<RunResult> run_scenario(const scenario::Scenario& scenario, const scenario::Plan& plan,
                                const RunOptions& options, const RunListener& listener) {
  if (options.virtual_time) return run_in_virtual_time(scenario, plan, options, listener);
  const interruption::Hold hold;
  const RunDirectory directory(options.directory);
  auto place =
      options.cell
          ? Place{options.cell->endpoints, options.cell->ports_file, {}}
          : own_place(plan, directory,
                      {.pacers = "", .journal = options.journal, .patience = options.patience});
  if (!place) return tl::unexpected(place.error());
  // A daemon without connections ends at once, so the connection is closed first.
  std::optional<CellConnection> connection(std::in_place, place->endpoints);
  CellConnection& cell = *connection;
  if (options.cell) {
    if (auto ready = make_ready(scenario, plan, cell); !ready) return tl::unexpected(ready.error());
  }
  // An attached cell is resumed however the run fails.
  const auto fail_with = [&](Failure failure) {
    if (options.cell) static_cast<void>(cell.resume());
    return tl::unexpected(std::move(failure));
  };
  auto description = cell.cell();
  if (!description) return fail_with(description.error());

  std::optional<Controller> controller;
  if (options.controller == kNoController) {
    listener.event({0, "waits for a controller; ports: " + place->ports_file});
  } else {
    // It polls as often in simulated time as at real speed, if possible.
    const double poll_ms = std::clamp(25 / options.speed.value_or(25), 1.0, 25.0);
    controller.emplace(
        controller_command(scenario, {.command = options.controller, .poll_ms = poll_ms}, *place),
        place->ports_file, directory);
    if (auto started = controller->start(); !started) return fail_with(started.error());
  }

  std::ofstream heard(directory.file("controller.out"));
  RunWatch run(scenario, plan, cell, std::move(*description),
               controller ? &controller->process() : nullptr, options.controller.empty(), heard,
               listener);
  Outcome<void> watched;
  if (auto injected = run.inject(); !injected) {
    watched = tl::unexpected(injected.error());
  } else {
    watched = watch_by_wall_clock(cell, run, controller ? &*controller : nullptr, options.speed);
  }
  if (controller && controller->is_there()) end_controller(controller->process(), run);
  if (auto left = leave(*place, connection, run, directory, watched); !left) {
    return tl::unexpected(left.error());
  }
  if (interruption::happened()) return failed(FailureKind::kInterrupted, "interrupted");
  RunResult result = run.result();
  result.controller = options.controller.empty() ? scenario.program : options.controller;
  return result;
}

}  // namespace aprsim::client
