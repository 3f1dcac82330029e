#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "world/api/ports/ports.hpp"
#include "world/api/ports/snapshot_feed.hpp"
#include "world/api/snapshot/solver_work.hpp"
#include "world/base/duration_histogram.hpp"
#include "world/cell/world.hpp"
#include "world/robot/planning/plan_job.hpp"
#include "world/runtime/commands/command_queue.hpp"
#include "world/runtime/publish/event_log.hpp"
#include "world/runtime/publish/snapshot_slot.hpp"
#include "world/runtime/record/recorder.hpp"
#include "world/runtime/saved_states.hpp"
#include "world/runtime/time/pacer.hpp"
#include "world/runtime/time/virtual_clock.hpp"

namespace aprsim::world {

struct SimulationOptions {
  std::uint64_t seed = 1;
  std::optional<double> speed = 1.0;  ///< nullopt = as fast as possible
  bool paused = false;                ///< start paused: stepped by a client
  std::size_t queue_capacity = 1024;
  std::uint64_t max_saved_bytes = std::uint64_t{64} << 20;  ///< of saved states together
  /// Clients pace; `speed` holds while none does. nullopt = the wall clock alone.
  std::optional<VirtualTimeOptions> virtual_time = {};
  /// Hears of all that decides what happens; outlives the simulation. Null = nobody.
  Recorder* recorder = nullptr;
};

/// Runs a world on its own thread: drain commands, step, publish, pace. The only code that touches
/// the world once it runs; motion plans are made ahead by a thread for each robot.
class Simulation final : public api::CommandSink, public api::SnapshotSource {
 public:
  /// Builds the world (throws std::runtime_error as World does) and publishes its first snapshot;
  /// start() sets it going.
  Simulation(std::shared_ptr<const scene::Scene> scene, SimulationOptions options);
  ~Simulation() override;
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  void start();
  /// Ends the thread after the step it is in. Safe to call twice.
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
  /// Whether the thread has made a turn of late, be it paused or in a fault; true before start()
  /// and after stop(). Thread: any.
  [[nodiscard]] bool makes_progress() const;
  /// Wall times of the steps taken since the start. Thread: any.
  [[nodiscard]] const api::DurationHistogram& step_times() const { return step_times_; }
  /// Thread: any.
  [[nodiscard]] api::SolverWork solver_work() const { return solver_work_.get(); }
  /// Commands that wait for the next step. Thread: any.
  [[nodiscard]] std::size_t waiting_commands() const { return queue_.size(); }
  /// The scene as it was loaded last, without changes of the running cell. Thread: any.
  [[nodiscard]] std::shared_ptr<const scene::Scene> scene() const;
  /// Every snapshot that is published. Thread: any.
  [[nodiscard]] api::SnapshotFeed& feed() { return followers_; }
  /// What has happened in the cell, of all epochs. Thread: any.
  [[nodiscard]] const api::EventSource& events() const { return events_; }
  /// Null when the wall clock alone passes time. Thread: any.
  [[nodiscard]] api::VirtualTime* virtual_time() { return clock_.get(); }

 private:
  void run(const std::stop_token& stop);
  /// Asks the virtual clock who passes time now.
  void look_at_clock();
  /// Whether commands take effect now: those of clients that pace wait until time goes on.
  [[nodiscard]] bool may_drain();
  [[nodiscard]] int steps_due();
  void drain();
  /// Applies one command; what it throws is a fault or that command's failure.
  void apply(const QueuedCommand& queued);
  [[nodiscard]] Result<void> carry_out(const QueuedCommand& queued);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::SimulationCommand& command);
  [[nodiscard]] Result<void> run_until(api::Ticket ticket, const api::RunUntil& wanted);
  /// After a step, or at the run's begin.
  void look_at_run();
  /// Nothing without a run.
  void end_run(api::RunEnd::Why why, std::string text, std::uint64_t event = 0);
  /// One step. False when time stands now.
  bool advance();
  [[nodiscard]] Result<void> reset(const api::Reset& wanted);
  void set_scene(std::shared_ptr<const scene::Scene> scene);
  [[nodiscard]] Result<void> edit(const api::SceneCommand& command);
  [[nodiscard]] Result<void> save(const api::SaveState& command);
  [[nodiscard]] Result<void> load(const api::LoadState& command);
  /// The world stands still until a reset or a load.
  void stop_world(const std::string& why);
  void record_failure(api::Ticket ticket, Error error);
  /// `loaded`: name of the saved state that it begins with; null = none.
  void begin_epoch(std::shared_ptr<const std::string> loaded = nullptr);
  /// For problem(): once a turn of the thread.
  void note_progress();
  [[nodiscard]] std::size_t backlog_limit() const;
  void publish();
  void write_snapshot();
  void tell(api::CellEventKind kind, std::string text);
  /// Numbers what the world has found.
  void number_events();
  /// Hands on what is numbered, before the snapshot that tells of its number.
  void hand_on_events();
  // ---- for the recorder, where there is one
  [[nodiscard]] RunTime run_time() const { return {epoch_, world_->step_count()}; }
  void record_epoch();
  void record_step();
  void record_checkpoint();

  const std::shared_ptr<const scene::Scene> scene_at_start_;  ///< by any thread
  mutable std::mutex scene_mutex_;                            ///< held to copy a pointer
  std::shared_ptr<const scene::Scene> scene_;  ///< as it was loaded; the world's may be edited
  std::uint64_t revision_ = 0;                 ///< of the cell's description
  std::uint64_t seed_;
  CommandQueue queue_;
  SnapshotSlot slot_;
  api::SnapshotFollowers followers_;
  EventLog events_;
  std::vector<api::CellEventPtr> numbered_;  ///< to be handed on
  std::uint64_t last_event_ = 0;
  std::vector<std::unique_ptr<robot::PlanningThread>> planning_threads_;  ///< one a robot
  std::vector<robot::PlanPrefetcher*> prefetchers_;                       ///< the same
  ArmModels models_;                                                      ///< read once
  std::unique_ptr<World> world_;
  Pacer pacer_;
  api::DurationHistogram step_times_;
  api::SolverWorkSlot solver_work_;
  std::unique_ptr<VirtualClock> clock_;  ///< null = the wall clock alone
  VirtualClock::Turn turn_;              ///< of the clock; not paced without one
  std::vector<QueuedCommand> drained_;
  std::uint64_t epoch_ = 0;
  std::shared_ptr<const std::string> loaded_state_;
  api::Ticket applied_ = 0;
  bool paused_;
  std::uint64_t steps_wanted_ = 0;  ///< while paused
  /// A run that lasts.
  struct Run {
    api::Ticket ticket = 0;
    api::RunUntil wanted;
    std::uint64_t last_step = 0;
    int robot = -1;  ///< of a crossing
  };
  std::optional<Run> run_;
  std::shared_ptr<const std::vector<api::RunEnd>> run_ends_;
  std::string world_fault_;
  std::uint64_t world_stops_ = 0;
  bool paused_by_fault_ = false;  ///< the next epoch runs again
  SavedStates saved_;
  Recorder* recorder_;
  std::shared_ptr<const std::vector<api::CommandFailure>> failures_;
  bool dirty_ = false;                ///< something to publish although nothing stepped
  std::int64_t backlog_seen_ns_ = 0;  ///< wall time when too many commands waited last
  std::atomic<bool> ending_{false};   ///< what still waits is not carried out any more
  /// Wall times [ns]: of the thread's latest turn; since when the pace is too low, and too many
  /// commands wait (0 = is not so).
  std::atomic<std::int64_t> last_turn_ns_{0}, slow_since_ns_{0}, backlog_since_ns_{0};
  std::jthread thread_;
};

}  // namespace aprsim::world
