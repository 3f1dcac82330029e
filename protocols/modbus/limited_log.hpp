#pragma once

#include <chrono>
#include <cstdint>
#include <string_view>

#include "protocols/rate_limit.hpp"

namespace aprsim::modbus_server {

/// Log lines that a peer can provoke, limited in rate so that no peer can flood the log: a burst of
/// kBurst, then kPerSecond; the next line that passes says how many did not.
/// Thread: one at a time.
class LimitedLog {
 public:
  using Clock = protocols::RateLimit::Clock;
  static constexpr double kBurst = 20, kPerSecond = 5;

  void info(std::string_view line);
  void warn(std::string_view line);

  /// The bare limiter: whether a line may pass at this time. Counts those that may not.
  [[nodiscard]] bool admit(Clock::time_point now);
  [[nodiscard]] std::uint64_t suppressed() const { return suppressed_; }

 private:
  protocols::RateLimit limit_{kPerSecond, kBurst};
  std::uint64_t suppressed_ = 0;
};

}  // namespace aprsim::modbus_server
