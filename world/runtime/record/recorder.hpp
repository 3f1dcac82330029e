#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "world/api/values/cell_event.hpp"
#include "world/cell/world_state.hpp"
#include "world/runtime/commands/command_queue.hpp"

namespace aprsim::world {

class World;

/// A moment of a run: resets and loads of saved states so far, and steps since the last of them.
struct RunTime {
  std::uint64_t epoch = 0, step = 0;
  auto operator<=>(const RunTime&) const = default;
};

/// Sample of the world's state after a step, which a replay is compared with.
struct StateSample {
  std::uint64_t hash = 0;          ///< World::state_hash()
  std::vector<double> joints_rad;  ///< of all robots, one after the other
  std::vector<double> bodies_m;    ///< origins of trays and gears in W, three numbers each
  double belt_travel_m = 0;
};

/// Steps of simulated time between two samples, and between two checkpoints.
inline constexpr std::uint64_t kSampleSteps = 1000, kCheckpointSteps = 10'000;

/// Records everything that determines the course of the simulation, in order. Thread: sim; no call
/// waits, throws or takes long.
class Recorder {
 public:
  virtual ~Recorder() = default;
  /// An epoch begins, with this seed and scene, or with a saved state (its name; null = none). The
  /// checkpoint of that state follows; it has the edited scene.
  virtual void began(RunTime time, std::uint64_t seed, const std::string* loaded,
                     const std::shared_ptr<const scene::Scene>& scene) = 0;
  /// A command took effect after the step; null = nothing failed.
  virtual void applied(RunTime time, const QueuedCommand& command, const Error* failure) = 0;
  virtual void sampled(RunTime time, StateSample sample) = 0;
  virtual void saved(RunTime time, std::uint64_t hash, std::shared_ptr<const WorldState> state) = 0;
  /// An event of the cell.
  virtual void happened(const api::CellEventPtr& event) { static_cast<void>(event); }
  /// The world has stopped on a fault.
  virtual void stopped(RunTime time, const std::string& why) = 0;
  /// Whether a checkpoint is wanted before the next one is due. Thread: any.
  [[nodiscard]] virtual bool wants_checkpoint() const = 0;
};

/// The sample of a world. Thread: its.
[[nodiscard]] StateSample sample_of(const World& world);

}  // namespace aprsim::world
