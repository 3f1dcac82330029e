#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "world/api/ports/ports.hpp"
#include "world/api/ports/snapshot_feed.hpp"
#include "world/api/snapshot/solver_work.hpp"
#include "world/base/duration_histogram.hpp"
#include "world/base/rate_limit.hpp"
#include "world/runtime/commands/command_queue.hpp"
#include "world/runtime/health.hpp"
#include "world/runtime/preview/move_previewer.hpp"
#include "world/runtime/publish/snapshot_slot.hpp"
#include "world/runtime/simulation_core.hpp"
#include "world/runtime/simulation_options.hpp"
#include "world/runtime/time/step_scheduler.hpp"

namespace aprsim::world {

/// The thread of the simulation: drains commands, steps, publishes, and keeps the pace. It alone
/// uses the SimulationCore once it runs. The thread sleeps in the command queue only.
class Simulation final : public api::CommandSink, public api::SnapshotSource {
 public:
  /// Builds the world (throws std::runtime_error as World does) and publishes its first snapshot;
  /// start() starts the thread.
  Simulation(std::shared_ptr<const scene::Scene> scene, SimulationOptions options);
  ~Simulation() override;
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  void start();
  /// Ends the thread after its current step; may be called twice.
  void stop();

  [[nodiscard]] Result<api::Ticket> submit(api::Command command) override;
  [[nodiscard]] api::SnapshotPtr latest() const override { return slot_.latest(); }
  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override {
    return slot_.wait_newer(seen, deadline);
  }
  [[nodiscard]] api::SnapshotPtr wait_for_step(
      const api::SnapshotPtr& seen, std::uint64_t step,
      std::chrono::steady_clock::time_point deadline) const override {
    return slot_.wait_for_step(seen, step, deadline);
  }
  [[nodiscard]] std::string problem() const override;
  /// Whether the thread has made a turn lately, also while paused or stopped on a fault; true
  /// before start() and after stop(). Thread: any.
  [[nodiscard]] bool makes_progress() const;
  /// Wall times of the steps taken since the start. Thread: any.
  [[nodiscard]] const api::DurationHistogram& step_times() const { return step_times_; }
  /// Thread: any.
  [[nodiscard]] api::SolverWork solver_work() const { return solver_work_.get(); }
  /// Commands that wait for the next step. Thread: any.
  [[nodiscard]] std::size_t waiting_commands() const { return queue_.size(); }
  /// The scene as it was loaded last, without changes of the running cell. Thread: any.
  [[nodiscard]] std::shared_ptr<const scene::Scene> scene() const { return core_.scene(); }
  /// Every snapshot that is published. Thread: any.
  [[nodiscard]] api::SnapshotFeed& feed() { return followers_; }
  /// The events of the cell, of all epochs. Thread: any.
  [[nodiscard]] const api::EventSource& events() const { return core_.events(); }
  /// Previews of moves. Thread: any.
  [[nodiscard]] api::MovePreviews& previews() { return previews_; }
  /// Answers all previews; later ones are kUnavailable. Thread: any but the simulation's.
  void stop_previews() { previews_.stop(); }
  /// Null when the wall clock alone passes time. Thread: any.
  [[nodiscard]] api::VirtualTime* virtual_time() { return scheduler_.virtual_time(); }

 private:
  void run(const std::stop_token& stop);
  /// Queries the virtual clock, and records the turn for problem().
  void begin_turn();
  /// Whether commands take effect now: those of pacing clients wait until time goes on.
  [[nodiscard]] bool may_drain();
  /// Commands take effect between steps, also while paused.
  void drain(const std::stop_token& stop);
  [[nodiscard]] int steps_due();
  /// Sleeps while paused or stopped; `seen`: CommandQueue::changes() at the turn's beginning.
  void idle(std::uint64_t seen);
  /// Sleeps until a step is due.
  void wait_for_step(std::uint64_t seen);
  void take_steps(int count);
  /// One step. False when time does not go on at once.
  bool advance();
  /// Publishes what has changed without a step.
  void publish_changes();
  void publish();
  void write_snapshot();

  /// Asks for the scene that a command leads to. Thread: any.
  [[nodiscard]] Result<void> admit_scene(const api::Command& command) const;
  /// Limits changes of a cell that goes by the wall clock. Thread: any.
  [[nodiscard]] Result<void> admit_edit(const api::Command& command);

  const std::function<Result<void>(const scene::Scene&)> admits_scene_;
  std::mutex edits_mutex_;
  protocols::RateLimit edits_{api::kMaxEditsPerSecond, api::kMaxEditsAtOnce};
  CommandQueue queue_;
  SimulationCore core_;
  StepScheduler scheduler_;
  Health health_;
  SnapshotSlot slot_;
  api::SnapshotFollowers followers_;
  api::DurationHistogram step_times_;
  api::SolverWorkSlot solver_work_;
  std::vector<QueuedCommand> drained_;
  bool dirty_ = false;  ///< the latest snapshot is out of date
  MovePreviewer previews_;
  std::jthread thread_;
};

}  // namespace aprsim::world
