#pragma once

#include <atomic>
#include <cstdint>
#include <list>
#include <memory>

#include "world/api/ports/history.hpp"
#include "world/cell/world_state.hpp"

namespace aprsim::world {

/// LRU cache of computed states of past moments. Thread: one, unless told otherwise.
class PastStates {
 public:
  explicit PastStates(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

  /// Memory of the states. Thread: any.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_.load(std::memory_order_relaxed); }
  void keep(api::Moment moment, std::shared_ptr<const WorldState> state);
  struct Kept {
    api::Moment moment;
    std::shared_ptr<const WorldState> state;
  };
  /// The latest at or before a moment of its epoch, and not before `first`; null state = none.
  [[nodiscard]] Kept latest(api::Moment first, api::Moment moment);
  /// Null = none of exactly this moment.
  [[nodiscard]] std::shared_ptr<const WorldState> find(api::Moment moment) const;

 private:
  std::uint64_t max_bytes_;
  std::atomic<std::uint64_t> bytes_ = 0;
  std::list<Kept> kept_;  ///< the most recently used first
};

}  // namespace aprsim::world
