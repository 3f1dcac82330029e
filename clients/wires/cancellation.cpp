#include "clients/wires/cancellation.hpp"

#include <algorithm>
#include <thread>

namespace aprsim::client {

void sleep_until(std::chrono::steady_clock::time_point time, const Cancelled& cancelled) {
  while (!is_cancelled(cancelled)) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= time) return;
    std::this_thread::sleep_until(cancelled ? std::min(time, now + kCancellationPeriod) : time);
  }
}

}  // namespace aprsim::client
