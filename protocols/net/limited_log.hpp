#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "world/base/rate_limit.hpp"

namespace aprsim::protocols {

inline constexpr std::size_t kMaxLogText = 400;  ///< bytes of a line

/// A text of any origin, safe for the log: line ends, control characters and invalid UTF-8 are
/// escaped, and it is cut to `limit` bytes.
[[nodiscard]] std::string log_text(std::string_view text, std::size_t limit = kMaxLogText);

/// Log lines that a peer can cause, under the name of a listener. They are escaped, cut and limited
/// in rate, so that no peer can flood the log: a burst of kBurst, then kPerSecond. The next line
/// after suppressed ones gives their number. Thread: one at a time.
class LimitedLog {
 public:
  using Clock = RateLimit::Clock;
  static constexpr double kBurst = 20, kPerSecond = 5;

  explicit LimitedLog(std::string name) : name_(std::move(name)) {}

  void info(std::string_view line);
  void warn(std::string_view line);
  [[nodiscard]] const std::string& name() const { return name_; }

  /// The rate limit alone: whether a line may pass now. Counts suppressed lines.
  [[nodiscard]] bool admit(Clock::time_point now);
  [[nodiscard]] std::uint64_t suppressed() const { return suppressed_; }

 private:
  [[nodiscard]] bool admit_line();

  std::string name_;
  RateLimit limit_{kPerSecond, kBurst};
  std::uint64_t suppressed_ = 0;
};

}  // namespace aprsim::protocols
