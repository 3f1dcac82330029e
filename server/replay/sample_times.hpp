#pragma once

#include <cstdint>

#include "server/replay/motion_options.hpp"
#include "world/cell/world.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::server {

/// The times at which a replay is sampled: at a rate of simulated time since the run's beginning,
/// resets included. Thread: the replay's.
class SampleTimes {
 public:
  explicit SampleTimes(const MotionOptions& options) : options_(options) {}

  /// Whether a sample is due; call it after every step.
  [[nodiscard]] bool is_due(const world::World& world, world::RunTime time);
  /// The rate, as whole steps between samples allow it [1/s].
  [[nodiscard]] double rate_hz(const world::World& world) const;

 private:
  [[nodiscard]] std::uint64_t steps_between(const world::World& world) const;

  const MotionOptions options_;
  std::uint64_t epoch_ = 0;
  double base_s_ = 0, latest_s_ = 0;  ///< simulated time over all epochs
  std::uint64_t next_step_ = 0;       ///< of that time, for the next sample
};

}  // namespace aprsim::server
