#pragma once

#include <chrono>
#include <functional>
#include <thread>

#include "tests/support/patience.hpp"

namespace aprsim::test {

/// Calls `met` every 0.2 ms until it returns true; false if that takes longer than the limit.
inline bool eventually(const std::function<bool()>& met,
                       std::chrono::milliseconds limit = std::chrono::seconds(10) * kPatience) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!met()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  return true;
}

}  // namespace aprsim::test
