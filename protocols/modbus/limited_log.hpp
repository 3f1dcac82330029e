#pragma once

#include <chrono>
#include <cstdint>
#include <string_view>

namespace aprsim::protocols {

/// Log lines that a peer can provoke, limited in rate so that no peer can flood the log: a burst of
/// kBurst, then kPerSecond; the next line that passes says how many did not.
/// Thread: one at a time.
class LimitedLog {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kBurst = 20, kPerSecond = 5;

  void info(std::string_view line);
  void warn(std::string_view line);

  /// The bare limiter: whether a line may pass at this time. Counts those that may not.
  [[nodiscard]] bool admit(Clock::time_point now);
  [[nodiscard]] std::uint64_t suppressed() const { return suppressed_; }

 private:
  double tokens_ = kBurst;
  Clock::time_point refilled_ = Clock::now();
  std::uint64_t suppressed_ = 0;
};

}  // namespace aprsim::protocols
