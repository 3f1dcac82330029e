#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "clients/ros2/actions/goal_table.hpp"
#include "clients/ros2/simulation/simulation.hpp"

namespace aprsim::ros2 {

/// Progress of a goal of simulation_interfaces/action/SimulateSteps.
struct StepProgress {
  GoalId goal{};
  std::uint64_t completed = 0, remaining = 0;
};

/// The goals of simulation_interfaces/action/SimulateSteps: steps of a paused cell, taken in
/// batches, so that other requests are served and cancelled goals end between two of them. One
/// goal at a time. Results have the codes of SimulationResult. Thread: one.
class StepGoals {
 public:
  /// The most steps of a goal that take one call each; goals of more take kBatch a call.
  static constexpr std::uint64_t kMostSingle = 100;
  static constexpr std::uint64_t kBatch = 10;

  /// Takes that number of steps, and returns once they are taken.
  using Step = std::function<SimulationResult(std::uint64_t steps)>;

  /// Takes a goal or refuses it: the result is why; empty = it is accepted.
  [[nodiscard]] std::string accept(const GoalId& id, std::uint64_t steps,
                                   const google::protobuf::Duration& now);
  /// Cancels goals, as GoalTable does.
  [[nodiscard]] GoalTable::CancelAnswer cancel(const GoalId& id,
                                               const google::protobuf::Duration& stamp);
  /// Whether there are steps to take.
  [[nodiscard]] bool is_active() const { return active_.has_value(); }
  /// Takes the next batch. The progress, if steps were taken.
  std::optional<StepProgress> advance(const Step& step);
  /// Drops goals that ended long ago.
  void expire();

  [[nodiscard]] const GoalTable& goals() const { return goals_; }

 private:
  void end(GoalState state, SimulationResult result);

  GoalTable goals_;
  std::optional<StepProgress> active_;
};

}  // namespace aprsim::ros2
