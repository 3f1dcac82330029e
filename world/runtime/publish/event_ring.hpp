#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "world/api/values/cell_event.hpp"

namespace aprsim::world {

/// The latest events as bytes in memory that is allocated at construction: however many events
/// come, the ring never grows. Thread: one at a time.
class EventRing {
 public:
  /// Keeps at most `capacity` events (>= 1), fewer where they need more than `bytes`.
  EventRing(std::size_t capacity, std::size_t bytes);

  /// Appends an event and drops the oldest ones to make room. Texts that do not fit into an
  /// eighth of the ring are cut.
  void push(const api::CellEvent& event);

  [[nodiscard]] std::size_t size() const { return count_; }
  /// Bytes of an event, 0 = the oldest; for decode().
  [[nodiscard]] std::string_view bytes(std::size_t index) const;
  /// Number of an event, 0 = the oldest.
  [[nodiscard]] std::uint64_t sequence(std::size_t index) const { return slot(index).sequence; }
  /// Memory that the ring takes.
  [[nodiscard]] std::size_t memory() const;

  [[nodiscard]] static api::CellEvent decode(std::string_view bytes);

 private:
  struct Slot {
    std::uint64_t sequence = 0;
    std::size_t begin = 0, size = 0;
  };

  [[nodiscard]] const Slot& slot(std::size_t index) const {
    return slots_[(first_ + index) % slots_.size()];
  }
  void drop_oldest();
  void encode(const api::CellEvent& event);

  std::vector<Slot> slots_;  ///< a ring
  std::size_t first_ = 0, count_ = 0;
  std::vector<char> arena_;
  std::size_t end_ = 0;  ///< of the latest event in the arena
  std::string encoded_;
};

}  // namespace aprsim::world
