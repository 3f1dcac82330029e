#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "world/api/commands/simulation_command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/runtime/time/pacer.hpp"
#include "world/runtime/time/virtual_clock.hpp"

namespace aprsim::world {

/// Decides when steps are due: by virtual time while clients pace, else by the wall clock, which is
/// passed in. Thread: sim, but virtual_time() any.
class StepScheduler {
 public:
  /// Longest sleep of the simulation thread while no step is due by the wall clock.
  static constexpr std::chrono::milliseconds kMaxSleep{20};

  struct Options {
    SimTime step{};
    std::optional<double> speed;                       ///< nullopt = as fast as possible
    std::optional<VirtualTimeOptions> virtual_time{};  ///< nullopt = the wall clock alone
  };
  /// `wake`: see VirtualClock.
  StepScheduler(Options options, std::function<void()> wake, WallTime now);

  /// Once a turn of the thread: queries the virtual clock. Whether the state of virtual time has
  /// changed.
  bool update(WallTime now);
  /// Whether clients pace now.
  [[nodiscard]] bool is_paced() const { return turn_.paced; }
  /// Whether virtual time waits for a client now.
  [[nodiscard]] bool is_waiting() const { return turn_.paced && turn_.due == 0; }
  /// Endpoints whose commands wait until time goes on.
  [[nodiscard]] std::vector<api::EndpointId> endpoints() const;

  /// Steps to take now, at most a short burst.
  [[nodiscard]] int steps_due(WallTime now);
  /// Time of the next check while no step is due.
  [[nodiscard]] WallTime next_turn(WallTime now);

  /// Restarts the pace at this moment, after a pause, a stop or a load.
  void restart(WallTime now) { pacer_.restart(now); }
  /// Once a turn while the cell is paused or stopped.
  void idle(WallTime now);
  /// Paused or stopped: no client waits for time.
  void release_clients(WallTime now);
  /// Adopts a command of the simulation that has succeeded: its speed, or the start of a new count.
  void apply(const api::SimulationCommand& command, WallTime now);

  /// Lets virtual time follow the robots of the cell. Before its first snapshot is published.
  void follow(const std::shared_ptr<const api::CellDescription>& cell, WallTime now);

  /// After each step, before its snapshot is published.
  void stepped(WallTime now, std::chrono::nanoseconds cost);
  /// The step's snapshot has been published. Whether time may go on at once.
  [[nodiscard]] bool published(const api::Snapshot& snapshot, WallTime now);

  /// Speed that the wall clock is to reach; nullopt = none, or clients pace.
  [[nodiscard]] std::optional<double> target_speed() const;
  [[nodiscard]] double real_time_factor() const { return pacer_.real_time_factor(); }
  /// Null when the wall clock alone passes time. Thread: any.
  [[nodiscard]] api::VirtualTime* virtual_time() { return clock_.get(); }
  /// Writes speed, pace and the state of virtual time.
  void write(api::Snapshot& out) const;

 private:
  Pacer pacer_;
  const std::unique_ptr<VirtualClock> clock_;         ///< null = the wall clock alone
  VirtualClock::Turn turn_;                           ///< not paced without a virtual clock
  std::shared_ptr<const api::CellDescription> cell_;  ///< whose robots the clock knows
};

}  // namespace aprsim::world
