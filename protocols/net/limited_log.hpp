#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "world/base/rate_limit.hpp"

namespace aprsim::protocols {

inline constexpr std::size_t kMaxLogText = 400;  ///< bytes of a line

/// A text for the log, whoever wrote it: what would end the line or control a terminal is escaped,
/// what is no UTF-8 too; cut to `limit` bytes.
[[nodiscard]] std::string log_text(std::string_view text, std::size_t limit = kMaxLogText);

/// Log lines that a peer can provoke, under the name of a listener, escaped and cut, and limited in
/// rate so that no peer can flood the log: a burst of kBurst, then kPerSecond; the next line that
/// passes says how many did not. Thread: one at a time.
class LimitedLog {
 public:
  using Clock = RateLimit::Clock;
  static constexpr double kBurst = 20, kPerSecond = 5;

  explicit LimitedLog(std::string name) : name_(std::move(name)) {}

  void info(std::string_view line);
  void warn(std::string_view line);
  [[nodiscard]] const std::string& name() const { return name_; }

  /// The bare limiter: whether a line may pass at this time. Counts those that may not.
  [[nodiscard]] bool admit(Clock::time_point now);
  [[nodiscard]] std::uint64_t suppressed() const { return suppressed_; }

 private:
  [[nodiscard]] bool admit_line();

  std::string name_;
  RateLimit limit_{kPerSecond, kBurst};
  std::uint64_t suppressed_ = 0;
};

}  // namespace aprsim::protocols
