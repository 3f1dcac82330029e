#pragma once

#include <atomic>
#include <cstddef>

namespace aprsim::grpc_server {

/// Memory that all uploads of files take together. Thread: any.
class UploadBudget {
 public:
  explicit UploadBudget(std::size_t bytes) : left_(bytes) {}

  /// False if less is left; nothing is taken then.
  [[nodiscard]] bool take(std::size_t bytes) {
    std::size_t left = left_.load(std::memory_order_relaxed);
    do {
      if (bytes > left) return false;
    } while (!left_.compare_exchange_weak(left, left - bytes, std::memory_order_relaxed));
    return true;
  }
  void give_back(std::size_t bytes) { left_.fetch_add(bytes, std::memory_order_relaxed); }

 private:
  std::atomic<std::size_t> left_;
};

}  // namespace aprsim::grpc_server
