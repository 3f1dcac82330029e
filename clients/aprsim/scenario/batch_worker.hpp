#pragma once

#include <chrono>
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
  /// Shell command of the controller, which polls every robot; empty = the scenario's program.
  std::string controller;
  /// The command's controller takes one job after the other, as the default programs do.
  bool reuse_controller = false;
  std::string directory;  ///< for scene, logs and the controller's output; empty = none
  std::string journal;    ///< file or directory for the daemon's; empty = none
  std::chrono::seconds patience = kPatience;  ///< without progress, before a run is given up
};

/// Runs one plan of a scenario after the other in virtual time, with one daemon and one
/// controller: the cell is reset to each plan's scene, connections stay open. The result of a run
/// depends on its plan only, bit for bit.
///
/// A controller that takes one job after the other sends {"event": "ready"} when its connections
/// are open and whenever it is idle. {"begin": SEED} starts a job; {"end": true} means that no
/// more orders follow. The controller sends {"event": "end"} when it is done, and "ready" again
/// when it has stopped polling; the cell is paused then, so that all replies arrive. For other
/// controllers, and after a failed run, both programs are restarted.
///
/// Thread: one, which is the same for all calls.
class BatchWorker {
 public:
  BatchWorker(const scenario::Scenario& scenario, BatchWorkerOptions options);
  ~BatchWorker();
  BatchWorker(const BatchWorker&) = delete;
  BatchWorker& operator=(const BatchWorker&) = delete;

  /// Failures: a program that cannot be started, dies or hangs; an interruption. The next run
  /// restarts both programs.
  [[nodiscard]] Outcome<RunResult> run(const scenario::Plan& plan, const RunListener& listener);

  /// The daemon's process, while there is one.
  [[nodiscard]] std::optional<pid_t> daemon() const;
  /// Greatest memory of a daemon so far; 0 = unknown [bytes].
  [[nodiscard]] std::uint64_t peak_bytes() const { return peak_bytes_; }
  /// Number of starts of the programs.
  [[nodiscard]] unsigned starts() const { return starts_; }

 private:
  struct Programs;

  [[nodiscard]] Outcome<void> start(const scenario::Plan& plan);
  [[nodiscard]] Outcome<RunResult> run_once(const scenario::Plan& plan,
                                            const RunListener& listener);
  /// Resets the cell to the plan's scene and starts the controller's job.
  [[nodiscard]] Outcome<v1::CellDescription> begin(const scenario::Plan& plan);
  /// Waits until the controller has opened its connections.
  [[nodiscard]] Outcome<void> await_ready();
  void begin_job(std::uint64_t seed);
  /// Notifies the controller that no more orders follow.
  void end_job();
  /// Advances time until the run is over and the controller is done. Returns the hash of the
  /// final state.
  [[nodiscard]] Outcome<std::string> pass_time(std::uint64_t seed, RunWatch& watch);
  /// Kills and restarts the controller.
  [[nodiscard]] Outcome<void> replace_controller(const v1::Snapshot& now, std::uint64_t seed,
                                                 SampleTime& time, RunWatch& watch);
  /// Pauses the cell and waits for the controller. Returns whether another run can follow.
  [[nodiscard]] bool gets_ready(RunWatch& watch);
  void end_programs();

  const scenario::Scenario& scenario_;
  const BatchWorkerOptions options_;
  const bool reuse_controller_;
  std::unique_ptr<Programs> programs_;
  std::uint64_t peak_bytes_ = 0;
  unsigned starts_ = 0;
};

}  // namespace aprsim::client
