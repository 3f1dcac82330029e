#pragma once

#include <atomic>
#include <cstdint>

namespace aprsim::api {

/// Work of the contact solver since the world was built.
struct SolverWork {
  std::uint64_t solved = 0;      ///< groups of touching bodies, each in each step
  std::uint64_t iterations = 0;  ///< of all these
};

/// The latest, for other threads: one sets, any reads, neither waits. A reader may get
/// values of two successive steps.
class SolverWorkSlot {
 public:
  void set(const SolverWork& work) {
    solved_.store(work.solved, std::memory_order_relaxed);
    iterations_.store(work.iterations, std::memory_order_relaxed);
  }
  [[nodiscard]] SolverWork get() const {
    return {solved_.load(std::memory_order_relaxed), iterations_.load(std::memory_order_relaxed)};
  }

 private:
  std::atomic<std::uint64_t> solved_{0}, iterations_{0};
};

}  // namespace aprsim::api
