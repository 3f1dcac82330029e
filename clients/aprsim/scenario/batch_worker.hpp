#pragma once

#include <memory>
#include <optional>
#include <string>
#include <sys/types.h>

#include "clients/aprsim/scenario/run_result.hpp"
#include "clients/aprsim/scenario/run_watch.hpp"
#include "clients/aprsim/scenario/runner.hpp"
#include "clients/aprsim/scenario/sample_time.hpp"
#include "clients/wires/outcome.hpp"
#include "world/scenario/plan.hpp"
#include "world/scenario/scenario.hpp"

namespace aprsim::client {

struct BatchWorkerOptions {
  /// A command for the shell in place of the scenario's own program; it polls every robot.
  std::string controller;
  /// That command starts a controller which takes one job after the other, as the own programs do.
  bool again = false;
  std::string directory;  ///< keeps scene, logs and what the controller says; empty = nothing
  std::string journal;    ///< file or directory for the daemon's; empty = none
};

/// A daemon and a controller for one run of a scenario after the other, in virtual time: the cell
/// is reset to each plan's scene, connections stay. A run depends on its plan alone, to the bit,
/// whatever ran before it.
///
/// A controller that takes one job after the other says {"event": "ready"} once its connections are
/// there and whenever it has nothing to do; {"begin": SEED} begins a job, {"end": true} tells it
/// that no more orders come; it says {"event": "end"} when it has done all, and "ready" again once
/// it polls no more: the cell is paused then, so that all answers come. With another controller,
/// and after a run that did not end in order, both programs are started anew.
///
/// Thread: one, which is the same for all calls.
class BatchWorker {
 public:
  BatchWorker(const scenario::Scenario& scenario, BatchWorkerOptions options);
  ~BatchWorker();
  BatchWorker(const BatchWorker&) = delete;
  BatchWorker& operator=(const BatchWorker&) = delete;

  /// Failures: what cannot be started, a program that dies or does not go on, an interruption. The
  /// next run begins with new programs then.
  [[nodiscard]] Outcome<RunResult> run(const scenario::Plan& plan, const RunListener& listener);

  /// The daemon's process, while there is one.
  [[nodiscard]] std::optional<pid_t> daemon() const;
  /// Greatest memory of a daemon so far; 0 = unknown [bytes].
  [[nodiscard]] std::uint64_t peak_bytes() const { return peak_bytes_; }
  /// How often the programs were started.
  [[nodiscard]] unsigned starts() const { return starts_; }

 private:
  struct Programs;

  [[nodiscard]] Outcome<void> start(const scenario::Plan& plan);
  [[nodiscard]] Outcome<RunResult> run_once(const scenario::Plan& plan,
                                            const RunListener& listener);
  /// Resets the cell to the plan's scene and has the controller begin.
  [[nodiscard]] Outcome<v1::CellDescription> begin(const scenario::Plan& plan);
  void begin_job(std::uint64_t seed);
  /// Tells the controller that no more orders come.
  void end_job();
  /// Passes time until the run is over and the controller has nothing more to do; the hash of the
  /// state in which the run ended.
  [[nodiscard]] Outcome<std::string> pass_time(std::uint64_t seed, RunWatch& watch);
  /// Kills the controller and starts another one in its place.
  [[nodiscard]] Outcome<void> replace_controller(const v1::Snapshot& now, std::uint64_t seed,
                                                 SampleTime& time, RunWatch& watch);
  /// Pauses the cell and waits for the controller; whether another run can follow.
  [[nodiscard]] bool gets_ready(RunWatch& watch);
  void end_programs();

  const scenario::Scenario& scenario_;
  const BatchWorkerOptions options_;
  const bool again_;
  std::unique_ptr<Programs> programs_;
  std::uint64_t peak_bytes_ = 0;
  unsigned starts_ = 0;
};

}  // namespace aprsim::client
