#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "world/api/faults/fault.hpp"
#include "world/api/values/cell_event.hpp"
#include "world/api/values/state_ptr.hpp"
#include "world/api/values/ticket.hpp"
#include "world/base/time.hpp"

/// Commands to the simulation itself: its pace and its states.
namespace aprsim::api {

struct Pause {};
struct Resume {};
/// Advances exactly this many steps while paused (or stepped), then stays paused.
struct StepBy {
  std::uint64_t steps = 1;
};
inline constexpr double kMinSpeed = 1e-3, kMaxSpeed = 1e6;
/// Target ratio of simulated to wall time, kMinSpeed to kMaxSpeed; nullopt = as fast as possible.
/// Never changes the step.
struct SetSpeed {
  std::optional<double> factor;
};
/// Another scene for a running cell, read and checked before.
class NextScene {
 public:
  virtual ~NextScene() = default;
  /// Self-contained, models by the names of their files.
  [[nodiscard]] virtual const std::string& text() const = 0;
  [[nodiscard]] virtual const std::string& name() const = 0;
};
/// Rebuilds the world from its scene as it was loaded, or from another scene.
/// Sockets stay open; Snapshot::epoch rises by one.
struct Reset {
  std::optional<std::uint64_t> seed;
  std::string scene_name{},
      scene_text{};  ///< one of both for another scene; empty = the same scene
  /// Read from these when the command is submitted.
  std::shared_ptr<const NextScene> next{};
};

inline constexpr std::size_t kMaxSavedStates = 64;
inline constexpr std::size_t kMaxStateName = 64;
/// Saves a state of the world under a name, in place of an earlier one; fails when kMaxSavedStates
/// others are saved or all together would take too much memory. Saved states outlive resets, not
/// the process.
struct SaveState {
  std::string name;
  StatePtr state = {};  ///< of a world of this scene; null = the present one
};
/// Continues from a saved state, bit for bit; fails when none has the name. Snapshot::epoch
/// rises by one.
struct LoadState {
  std::string name;
  StatePtr state = {};  ///< of a world of this scene, called `name`; null = the one saved as that
};
/// Forgets a saved state; fails when none has the name.
struct DeleteState {
  std::string name;
};

/// Simulated time since the last reset is so much.
struct UntilTime {
  SimTime time{};
};
/// An event of one of these kinds that involves one of these things; empty = any.
struct UntilEvent {
  std::vector<CellEventKind> kinds;
  std::vector<std::string> names;
};
inline constexpr std::uint64_t kMaxRunSteps = 10'000'000;
/// Runs at the set speed until the condition holds at a step's end, or for this number of steps,
/// and pauses. A condition that holds already takes no step. Pauses, resets and loads end the run;
/// Snapshot::runs has its outcome.
struct RunUntil {
  /// A crossing: the quantity is beyond the limit. Nothing: only the steps count.
  std::variant<std::monostate, UntilTime, UntilEvent, WhenCrossing> until;
  std::uint64_t steps = kMaxRunSteps;  ///< 1 to kMaxRunSteps
  ResolvedCrossingPtr resolved{};      ///< of a crossing, set by world::check(); null = not checked
};
/// Pauses if the run of this ticket has not ended.
struct EndRun {
  Ticket run = 0;
};
using SimulationCommand = std::variant<Pause, Resume, StepBy, SetSpeed, Reset, SaveState, LoadState,
                                       DeleteState, RunUntil, EndRun>;

}  // namespace aprsim::api
