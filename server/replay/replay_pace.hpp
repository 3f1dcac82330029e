#pragma once

#include <chrono>
#include <optional>

#include "server/replay/replay.hpp"

namespace aprsim::server::journal {

/// When the steps of a replay are due on the wall clock. Thread: one.
class ReplayPace {
 public:
  /// Ratio of simulated to wall time; absent = as fast as possible.
  explicit ReplayPace(std::optional<double> speed) : speed_(speed) {}

  /// Wall time of an instant of the replay's watch; time that the machine loses is not caught up
  /// with.
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
