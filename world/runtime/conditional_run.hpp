#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "world/api/commands/simulation_command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/api/values/cell_event.hpp"
#include "world/base/with_appended.hpp"
#include "world/cell/world.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::world {

/// The RunUntil in progress, its condition, and how the latest runs ended. Thread: sim.
class ConditionalRun {
 public:
  struct Outcome {
    api::RunEnd::Why why = api::RunEnd::Why::kMet;
    std::string text{};       ///< the cause of an interruption
    std::uint64_t event = 0;  ///< number of the event that met the condition; 0 = none
  };

  /// Begins a run after the world's step `step`; no other may be in progress. `robot`: index of the
  /// robot of a WhenCrossing, as resolve() returns it.
  void begin(api::Ticket ticket, const api::RunUntil& wanted, int robot, std::uint64_t step);
  [[nodiscard]] bool is_active() const { return run_.has_value(); }
  /// Whether the run in progress has this ticket.
  [[nodiscard]] bool is_active(api::Ticket ticket) const { return run_ && run_->ticket == ticket; }

  /// The outcome of the active run if it is over after the latest step, with the events of that
  /// step; nullopt = it goes on.
  [[nodiscard]] std::optional<Outcome> check(const World& world,
                                             std::span<const api::CellEventPtr> events) const;
  /// Ends the active run.
  void end(RunTime time, Outcome outcome);

  /// The latest api::kMaxRunEnds runs that have ended, in order; null = none.
  [[nodiscard]] const SharedList<api::RunEnd>& ends() const { return ends_; }

 private:
  struct Run {
    api::Ticket ticket = 0;
    api::RunUntil wanted;
    int robot = -1;
    std::uint64_t last_step = 0;
  };
  [[nodiscard]] std::optional<Outcome> check_condition(
      const World& world, std::span<const api::CellEventPtr> events) const;

  std::optional<Run> run_;
  SharedList<api::RunEnd> ends_;
};

}  // namespace aprsim::world
