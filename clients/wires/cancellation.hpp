#pragma once

#include <chrono>
#include <functional>

namespace aprsim::client {

/// Asked every few milliseconds while a call waits. True ends the call with
/// FailureKind::kInterrupted; empty = the call waits until its deadline. With a std::stop_token:
/// `[token] { return token.stop_requested(); }`. Thread: the one that waits.
using Cancelled = std::function<bool()>;

/// A call that waits asks at least this often.
inline constexpr std::chrono::milliseconds kCancellationPeriod{10};

/// False also where nothing can cancel.
[[nodiscard]] inline bool is_cancelled(const Cancelled& cancelled) {
  return cancelled && cancelled();
}

/// Sleeps until that time, or until `cancelled` says true.
void sleep_until(std::chrono::steady_clock::time_point time, const Cancelled& cancelled);

}  // namespace aprsim::client
