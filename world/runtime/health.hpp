#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "world/api/snapshot/snapshot.hpp"
#include "world/runtime/time/pacer.hpp"

namespace aprsim::world {

/// Watches whether the simulation thread makes progress, keeps its pace and keeps up with the
/// commands. The wall clock is passed in. Thread: the simulation thread records, any thread
/// queries; neither waits.
class Health {
 public:
  /// The state of the simulation at one turn of its thread.
  struct Load {
    std::size_t waiting_commands = 0;
    std::optional<double> speed{};  ///< target of the wall clock; nullopt = none now
    double pace = 0;                ///< measured ratio of simulated to wall time; 0 = not yet
  };

  explicit Health(std::size_t queue_capacity);

  /// Once a turn. Thread: sim.
  void record_turn(WallTime now, const Load& load);
  /// The thread has ended: no further turn is expected.
  void end();

  /// Whether the thread has made a turn lately; true before the first turn and after end().
  [[nodiscard]] bool makes_progress(WallTime now) const;
  /// The most severe problem in one sentence; empty = none. `snapshot`: the latest.
  [[nodiscard]] std::string problem(WallTime now, const api::Snapshot& snapshot) const;

 private:
  const std::size_t backlog_limit_;
  std::int64_t backlog_seen_ns_ = 0;  ///< the latest turn with too many commands
  /// Wall times [ns], 0 = none: the latest turn, and since when pace and backlog are a problem.
  std::atomic<std::int64_t> last_turn_ns_{0}, slow_since_ns_{0}, backlog_since_ns_{0};
};

}  // namespace aprsim::world
