#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "world/runtime/record/recorder.hpp"
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
  /// Motion plans are made ahead by one thread a robot; else by the stepping thread, with the same
  /// bits.
  bool plans_ahead = true;
  /// Records the run; outlives the simulation. Null = no record.
  Recorder* recorder = nullptr;
};

}  // namespace aprsim::world
