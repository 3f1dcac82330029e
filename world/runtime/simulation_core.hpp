#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "world/api/commands/command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/runtime/commands/command_queue.hpp"
#include "world/runtime/commands/command_results.hpp"
#include "world/runtime/current_world.hpp"
#include "world/runtime/publish/event_publisher.hpp"
#include "world/runtime/record/run_recording.hpp"
#include "world/runtime/run_control.hpp"
#include "world/runtime/saved_states.hpp"
#include "world/runtime/simulation_options.hpp"

namespace aprsim::world {

/// A simulation without its thread and clock: applies commands between steps,
/// steps the world, stops on faults, and records all of it. Thread: sim, unless said otherwise.
class SimulationCore {
 public:
  /// Builds the world and records the first epoch. Throws std::runtime_error as World does.
  SimulationCore(std::shared_ptr<const scene::Scene> scene, const SimulationOptions& options);
  SimulationCore(const SimulationCore&) = delete;
  SimulationCore& operator=(const SimulationCore&) = delete;

  /// Applies a command that has been checked, and records its result. A failure is that of this
  /// command; an exception of the world stops the world, too.
  Result<void> execute(const QueuedCommand& queued);

  /// Takes one step. False: it failed, and the world has stopped in its last good state.
  [[nodiscard]] bool step();
  /// Takes all counted steps at once, if the world is at rest and nobody observes single steps.
  /// False: it has taken none.
  [[nodiscard]] bool take_still_steps();
  /// After a successful step: records it, and ends a run whose condition is met.
  void complete_step();
  /// Between two steps: a checkpoint, if the recorder wants one and the world has not stopped.
  void record_wanted_checkpoint();

  /// Publishes all events so far; call it before write().
  void publish_events();
  /// Writes the snapshot, apart from speed and virtual time.
  void write(api::Snapshot& out) const;

  [[nodiscard]] const World& world() const { return *world_; }
  [[nodiscard]] const RunControl& control() const { return control_; }
  /// Thread: any.
  [[nodiscard]] const api::EventSource& events() const { return events_.log(); }
  /// See CurrentWorld. Thread: any.
  [[nodiscard]] std::shared_ptr<const scene::Scene> scene() const { return world_.scene(); }
  [[nodiscard]] const scene::Scene& scene_at_start() const { return world_.scene_at_start(); }

 private:
  [[nodiscard]] Result<void> carry_out(const QueuedCommand& queued);
  // One overload a command of the simulation itself. SetSpeed concerns the clock alone.
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::Pause& command);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::Resume& command);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::StepBy& command);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::SetSpeed& command);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::Reset& command);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::SaveState& command);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::LoadState& command);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::DeleteState& command);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::RunUntil& command);
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::EndRun& command);
  /// The world stops until a reset or a load.
  void stop_world(const std::string& why);
  /// `loaded`: name of the saved state that it begins with; null = none.
  void begin_epoch(std::shared_ptr<const std::string> loaded = nullptr);
  void record_epoch();
  void assign_event_ids();
  void report(api::CellEventKind kind, std::string text);
  [[nodiscard]] RunTime run_time() const { return {control_.epoch(), world_->step_count()}; }

  CurrentWorld world_;
  RunControl control_;
  RunRecording recording_;
  EventPublisher events_;
  SavedStates saved_;
  CommandResults results_;
};

}  // namespace aprsim::world
