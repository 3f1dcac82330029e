#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "server/journal/frame.hpp"

namespace aprsim::server::journal {

/// The latest frames of a run, in memory: always from one that begins, so that what is kept can be
/// run again. Thread: one at a time.
class FrameRing {
 public:
  /// Keeps as much as makes `max_steps` of simulated time, or less where that takes more than
  /// `max_bytes`.
  FrameRing(std::uint64_t max_steps, std::size_t max_bytes)
      : max_steps_(max_steps), max_bytes_(max_bytes) {}

  void add(const Frame& frame);
  /// The frames from the last beginning that is `steps` or more before `clock`, or from the oldest;
  /// empty where there is none.
  [[nodiscard]] std::vector<FrameBytes> last(std::uint64_t steps, std::uint64_t clock) const;
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  /// Whether a new beginning is wanted, so that older frames can go.
  [[nodiscard]] bool wants_beginning() const;

 private:
  struct Stretch {
    std::uint64_t clock = 0;  ///< at its beginning
    std::size_t bytes = 0;
    std::vector<FrameBytes> frames;
  };

  const std::uint64_t max_steps_;
  const std::size_t max_bytes_;
  std::deque<Stretch> stretches_;  ///< each from a beginning to the next
  std::size_t bytes_ = 0;
};

}  // namespace aprsim::server::journal
