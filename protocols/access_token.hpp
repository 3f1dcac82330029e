#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "protocols/rate_limit.hpp"

namespace aprsim::protocols {

/// The token that commands from the page and over gRPC come with, and who has guessed at it. After
/// kBurst wrong ones an address waits for each further attempt, also with the right one: else a
/// guess would be told from the token however often it is tried. Thread: any.
class AccessToken {
 public:
  using Clock = RateLimit::Clock;
  enum class Verdict : std::uint8_t { kRight, kWrong, kTooManyAttempts };
  static constexpr double kBurst = 5, kPerSecond = 0.2;

  explicit AccessToken(std::string token) : token_(std::move(token)) {}

  /// Whether the client at this numeric host knows the token.
  [[nodiscard]] Verdict check(std::string_view host, std::string_view given,
                              Clock::time_point now = Clock::now());

 private:
  [[nodiscard]] RateLimit& attempts_of(const std::string& address, Clock::time_point now);

  const std::string token_;
  std::mutex mutex_;
  std::map<std::string, RateLimit> attempts_;  // of the addresses that have failed of late
  RateLimit others_{kPerSecond, kBurst};       // all together, once those are too many
};

}  // namespace aprsim::protocols
