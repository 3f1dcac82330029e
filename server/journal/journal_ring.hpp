#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <string>

namespace aprsim::server::journal {

/// The latest frames of a run, kept in memory: each part begins with a checkpoint, and the oldest
/// parts go first. Thread: one at a time.
class JournalRing {
 public:
  using Clock = std::chrono::steady_clock;

  JournalRing(std::size_t max_bytes, std::chrono::seconds keep)
      : max_bytes_(max_bytes), keep_(keep) {}

  /// The next frames begin with a checkpoint.
  void begin_part(Clock::time_point now);
  /// A frame of the present part.
  void append(std::string frame);

  /// A journal file of all that is kept, after the frame of its header.
  [[nodiscard]] std::string file(const std::string& header_frame) const;
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  struct Part {
    Clock::time_point begin;
    std::string frames;
  };
  void drop_oldest();

  const std::size_t max_bytes_;
  const std::chrono::seconds keep_;
  std::deque<Part> parts_;
  std::size_t bytes_ = 0;
};

}  // namespace aprsim::server::journal
