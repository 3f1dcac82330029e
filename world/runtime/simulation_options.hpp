#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "world/base/result.hpp"
#include "world/runtime/record/recorder.hpp"
#include "world/runtime/time/virtual_clock.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

struct SimulationOptions {
  std::uint64_t seed = 1;
  std::optional<double> speed = 1.0;  ///< nullopt = as fast as possible
  bool paused = false;                ///< start paused: stepped by a client
  std::size_t queue_capacity = 1024;
  std::uint64_t max_saved_bytes = std::uint64_t{64} << 20;  ///< of saved states together
  /// Clients pace; `speed` holds while none does. nullopt = the wall clock alone.
  std::optional<VirtualTimeOptions> virtual_time = {};
  /// Motion plans are made ahead by one thread a robot; else by the stepping thread, with the same
  /// bits.
  bool plans_ahead = true;
  /// Asked for the scene of a reset or of a saved state before the command is queued; an error
  /// refuses it. Thread: that of the submission. Null = all are admitted.
  std::function<Result<void>(const scene::Scene&)> admits_scene = {};
  /// Records the run; outlives the simulation. Null = no record.
  Recorder* recorder = nullptr;
};

}  // namespace aprsim::world
