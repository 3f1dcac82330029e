#pragma once

#include <chrono>

namespace aprsim::simple_message {

/// When the next state is sent, a period after `due`, the last one's time. A machine that was late
/// leaves the missed states out, and sends none of them twice.
[[nodiscard]] inline std::chrono::steady_clock::time_point next_state(
    std::chrono::steady_clock::time_point due, std::chrono::steady_clock::duration period,
    std::chrono::steady_clock::time_point now) {
  return due + period > now ? due + period : now + period;
}

}  // namespace aprsim::simple_message
