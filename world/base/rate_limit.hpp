#pragma once

#include <algorithm>
#include <chrono>

namespace aprsim::protocols {

/// A token bucket: admits `per_second` events a second on average, `burst` at once at most.
/// Thread: one at a time.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// `per_second` 0 = no limit. The burst size is `per_second`.
  explicit RateLimit(double per_second) : RateLimit(per_second, per_second) {}
  RateLimit(double per_second, double burst)
      : per_second_(per_second), burst_(burst), tokens_(burst) {}

  [[nodiscard]] bool admit(Clock::time_point now) {
    if (!has_room(now)) return false;
    if (per_second_ > 0) tokens_ -= 1;
    return true;
  }
  /// Whether admit() would.
  [[nodiscard]] bool has_room(Clock::time_point now) {
    refill(now);
    return per_second_ <= 0 || tokens_ >= 1;
  }
  /// Whether nothing has been admitted that still counts.
  [[nodiscard]] bool is_full(Clock::time_point now) const {
    const std::chrono::duration<double> since = now - refilled_;
    return tokens_ + per_second_ * since.count() >= burst_;
  }

 private:
  void refill(Clock::time_point now) {
    const std::chrono::duration<double> since = now - refilled_;
    if (since.count() <= 0) return;
    // The first call has an arbitrary time difference; the full bucket absorbs it.
    tokens_ = std::min(burst_, tokens_ + per_second_ * since.count());
    refilled_ = now;
  }

  double per_second_, burst_;
  double tokens_;
  Clock::time_point refilled_{};
};

}  // namespace aprsim::protocols
