#pragma once

#include <chrono>
#include <optional>

#include "server/replay/replay.hpp"

namespace aprsim::server::journal {

/// Times of the steps of a replay on the wall clock. Thread: one.
class ReplayPace {
 public:
  /// Ratio of simulated to wall time; absent = as fast as possible.
  explicit ReplayPace(std::optional<double> speed) : speed_(speed) {}

  /// Wall time of an instant of the replay; lost time is not caught up.
  [[nodiscard]] std::chrono::steady_clock::time_point due(const world::World& world,
                                                          world::RunTime time);

 private:
  const std::optional<double> speed_;
  std::optional<world::RunTime> last_;
  std::chrono::steady_clock::time_point due_{};
};

/// Waits for each step.
[[nodiscard]] Replay::Watch paced(double speed);

}  // namespace aprsim::server::journal
