#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "world/api/state_ptr.hpp"

/// What is asked of the simulation itself: its pace and its states.
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
/// Builds the world anew from its scene. Sockets stay open; Snapshot::epoch rises by one.
struct Reset {
  std::optional<std::uint64_t> seed;
};

inline constexpr std::size_t kMaxSavedStates = 64;
inline constexpr std::size_t kMaxStateName = 64;
/// Keeps a state of the world under a name, in place of what had it; fails when kMaxSavedStates
/// others are kept or all together would take too much memory. Saved states outlive resets, not the
/// process.
struct SaveState {
  std::string name;
  StatePtr state = {};  ///< of a world of this scene; null = the present one
};
/// Goes on from a state, bit for bit; fails when none is saved under the name. Snapshot::epoch
/// rises by one.
struct LoadState {
  std::string name;
  StatePtr state = {};  ///< of a world of this scene, called `name`; null = the one saved as that
};
/// Forgets a saved state; fails when none has the name.
struct DeleteState {
  std::string name;
};
using SimulationCommand =
    std::variant<Pause, Resume, StepBy, SetSpeed, Reset, SaveState, LoadState, DeleteState>;

}  // namespace aprsim::api
