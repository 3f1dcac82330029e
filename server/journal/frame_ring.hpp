#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "server/journal/frame.hpp"

namespace aprsim::server::journal {

/// The latest frames of a run, in memory. They begin with a checkpoint, so that they can be
/// replayed. Frames that are dropped while somebody still sends them count until they are sent, so
/// slow readers never make it larger. Thread: one at a time.
class FrameRing {
 public:
  /// Keeps the last `max_steps` of simulated time, less where they need more than `max_bytes`.
  FrameRing(std::uint64_t max_steps, std::size_t max_bytes)
      : max_steps_(max_steps), max_bytes_(max_bytes) {}

  void add(const Frame& frame);
  /// The frames from the last checkpoint at least `steps` before `clock`, or from the oldest one;
  /// empty where there is none.
  [[nodiscard]] std::vector<FrameBytes> last(std::uint64_t steps, std::uint64_t clock) const;
  /// Size of the frames kept, and of those dropped that somebody still holds.
  [[nodiscard]] std::size_t bytes() const { return bytes_ + held_bytes(); }
  /// Drops the older half of the segments.
  void drop_older_half();
  /// Whether a checkpoint is wanted, so that older frames can be dropped.
  [[nodiscard]] bool wants_beginning() const;

 private:
  struct Segment {
    std::uint64_t clock = 0;  ///< of its first frame
    std::size_t bytes = 0;
    std::vector<FrameBytes> frames;
  };

  void drop_oldest();
  [[nodiscard]] std::size_t held_bytes() const;

  const std::uint64_t max_steps_;
  const std::size_t max_bytes_;
  std::deque<Segment> segments_;                       ///< each from a checkpoint to the next
  std::size_t bytes_ = 0;                              ///< of the segments
  std::deque<std::weak_ptr<const std::string>> held_;  ///< dropped while in use
};

}  // namespace aprsim::server::journal
