#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>

namespace aprsim::server {

/// Resident memory of this process [bytes]; 0 where the system does not say.
[[nodiscard]] std::uint64_t resident_bytes();

/// Keeps the process below its memory limit. Near the limit it returns freed memory to the system;
/// where that is not enough, it drops half of the recorded past. Thread: one at a time.
class MemoryGuard {
 public:
  using Clock = std::chrono::steady_clock;

  /// `relieve` drops data that is not essential; `resident` returns the memory in use [bytes].
  MemoryGuard(std::uint64_t limit_bytes, std::function<void()> relieve,
              std::function<std::uint64_t()> resident = resident_bytes);

  /// Acts at most every two seconds; call it more often.
  void check(Clock::time_point now);

 private:
  const std::uint64_t limit_;
  const std::function<void()> relieve_;
  const std::function<std::uint64_t()> resident_;
  std::optional<Clock::time_point> acted_;
  bool reported_ = false;
};

}  // namespace aprsim::server
