#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "world/runtime/conditional_run.hpp"

namespace aprsim::world {

/// Decides whether the world steps: pause, counted steps, a RunUntil, and the fault on which the
/// world has stopped. Counts the epochs. Parameters `step`: the world's present step. Thread: sim.
class RunControl {
 public:
  explicit RunControl(bool paused) : paused_(paused) {}

  [[nodiscard]] bool is_paused() const { return paused_; }
  /// Not paused, and no world fault.
  [[nodiscard]] bool is_running() const { return !paused_ && world_fault_.empty(); }
  /// Whether the next step is to be taken: running, or paused with counted steps left.
  [[nodiscard]] bool is_stepping() const {
    return world_fault_.empty() && (!paused_ || steps_wanted_ > 0);
  }
  /// Cause for which the world has stopped; empty = it has not.
  [[nodiscard]] const std::string& world_fault() const { return world_fault_; }
  [[nodiscard]] std::uint64_t epoch() const { return epoch_; }

  void pause(std::uint64_t step);
  void resume() { paused_ = false; }
  /// Pauses, and takes this many steps more.
  void step_by(std::uint64_t steps, std::uint64_t step);
  /// After each step.
  void count_step() { count_steps(1); }
  void count_steps(std::uint64_t steps);
  /// Counted steps that are left, while paused.
  [[nodiscard]] std::uint64_t steps_left() const { return paused_ ? steps_wanted_ : 0; }

  /// Runs until the condition of `wanted` holds. See ConditionalRun::begin().
  void begin_run(api::Ticket ticket, const api::RunUntil& wanted, int robot, std::uint64_t step);
  [[nodiscard]] bool has_run() const { return run_.is_active(); }
  /// Ends the run with this ticket, if it is active.
  void end_run(api::Ticket ticket, std::uint64_t step);
  /// Ends the active run, if any, for this cause.
  void interrupt_run(std::string why, std::uint64_t step);
  /// Pauses if the active run is over; see ConditionalRun::check().
  void check_run_condition(const World& world, std::span<const api::CellEventPtr> events);

  /// The world has stopped until the next epoch.
  void stop(const std::string& why, std::uint64_t step);
  /// `loaded`: name of the saved state that the epoch begins with; null = none.
  void begin_epoch(std::shared_ptr<const std::string> loaded, std::uint64_t step);
  /// Name of the saved state that the epoch began with; null = none.
  [[nodiscard]] const std::string* loaded_state() const { return loaded_state_.get(); }

  /// Writes epoch, pause, runs and fault.
  void write(api::Snapshot& out) const;

 private:
  /// Nothing without an active run.
  void end_active_run(ConditionalRun::Outcome outcome, std::uint64_t step);

  bool paused_;
  std::uint64_t steps_wanted_ = 0;  ///< while paused
  ConditionalRun run_;
  std::string world_fault_;
  std::uint64_t world_stops_ = 0;
  bool paused_by_fault_ = false;  ///< the next epoch runs
  std::uint64_t epoch_ = 0;
  std::shared_ptr<const std::string> loaded_state_;
};

}  // namespace aprsim::world
