#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace aprsim::bench {

inline constexpr int kThreads = 2;

/// Results of `work` for 0, 1, ..., count - 1, in this order, computed by two threads: for runs
/// that are not timed. An exception of a run is rethrown here once all have ended.
template <typename Work>
auto in_parallel(std::size_t count, const Work& work)
    -> std::vector<decltype(work(std::size_t{}))> {
  std::vector<decltype(work(std::size_t{}))> out(count);
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  std::mutex mutex;  // of `failure`
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        out[i] = work(i);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        failure = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 1; i < kThreads; ++i) threads.emplace_back(run);
    run();
  }
  if (failure) std::rethrow_exception(failure);
  return out;
}

}  // namespace aprsim::bench
