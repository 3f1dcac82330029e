#pragma once

#include <algorithm>
#include <chrono>

namespace aprsim::protocols {

/// A token bucket: admits `per_second` events a second on average, `burst` at once at most.
/// Thread: one at a time.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// `per_second` 0 = no limit. The burst is a second's worth.
  explicit RateLimit(double per_second) : RateLimit(per_second, per_second) {}
  RateLimit(double per_second, double burst)
      : per_second_(per_second), burst_(burst), tokens_(burst) {}

  [[nodiscard]] bool admit(Clock::time_point now) {
    if (per_second_ <= 0) return true;
    const std::chrono::duration<double> since = now - refilled_;
    if (since.count() > 0) {
      // The first call comes with an arbitrary distance; the bucket is full then, and stays so.
      tokens_ = std::min(burst_, tokens_ + per_second_ * since.count());
      refilled_ = now;
    }
    if (tokens_ < 1) return false;
    tokens_ -= 1;
    return true;
  }

 private:
  double per_second_, burst_;
  double tokens_;
  Clock::time_point refilled_{};
};

}  // namespace aprsim::protocols
