#pragma once

#include <cstddef>
#include <deque>
#include <functional>

#include "world/api/snapshot/snapshot.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::server::journal {

/// The snapshots that listeners could see in the latest steps of a replay: before and after the
/// commands between two steps. Thread: one at a time.
class WireMoments {
 public:
  static constexpr std::size_t kMost = 4000;

  /// Adds each step and command in order. False = it does not follow the one before; earlier ones
  /// are then dropped.
  bool add(world::RunTime time, const api::Snapshot& snapshot);

  [[nodiscard]] bool empty() const { return moments_.empty(); }
  [[nodiscard]] world::RunTime now() const { return moments_.back().time; }
  /// Whether all moments of this span are known.
  [[nodiscard]] bool covers(world::RunTime from, world::RunTime to) const {
    return !empty() && moments_.front().time <= from && to <= now();
  }
  /// Visits the moments of a span, the latest first, until `visit` returns false.
  void each_back(world::RunTime from, world::RunTime to,
                 const std::function<bool(const api::Snapshot&)>& visit) const;

 private:
  struct Moment {
    world::RunTime time;
    api::Snapshot snapshot;  ///< all that listeners report, without cameras
  };

  std::deque<Moment> moments_;
};

}  // namespace aprsim::server::journal
