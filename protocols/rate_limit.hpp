#pragma once

#include <algorithm>
#include <chrono>

namespace aprsim::protocols {

/// Admits so many events a second, a second's worth at once at most. Thread: one at a time.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// `per_second` 0 = no limit.
  explicit RateLimit(double per_second) : per_second_(per_second), tokens_(per_second) {}

  [[nodiscard]] bool admit(Clock::time_point now) {
    if (per_second_ <= 0) return true;
    const std::chrono::duration<double> since = now - refilled_;
    if (since.count() > 0) {
      // The first call comes with an arbitrary distance; the bucket is full then, and stays so.
      tokens_ = std::min(per_second_, tokens_ + per_second_ * since.count());
      refilled_ = now;
    }
    if (tokens_ < 1) return false;
    tokens_ -= 1;
    return true;
  }

 private:
  double per_second_;
  double tokens_;
  Clock::time_point refilled_{};
};

}  // namespace aprsim::protocols
