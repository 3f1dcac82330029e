#pragma once

#include <atomic>
#include <cstddef>

namespace aprsim::grpc_server {

/// Memory that all files on their way take together, in both directions. Thread: any.
class TransferBudget {
 public:
  explicit TransferBudget(std::size_t bytes) : max_(bytes), left_(bytes) {}

  /// False if less is left; nothing is taken then.
  [[nodiscard]] bool take(std::size_t bytes) {
    std::size_t left = left_.load(std::memory_order_relaxed);
    do {
      if (bytes > left) return false;
    } while (!left_.compare_exchange_weak(left, left - bytes, std::memory_order_relaxed));
    return true;
  }
  void give_back(std::size_t bytes) { left_.fetch_add(bytes, std::memory_order_relaxed); }
  [[nodiscard]] std::size_t max_bytes() const { return max_; }

 private:
  const std::size_t max_;
  std::atomic<std::size_t> left_;
};

}  // namespace aprsim::grpc_server
