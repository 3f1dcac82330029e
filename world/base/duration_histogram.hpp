#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace aprsim::api {

/// A histogram of durations with fixed buckets, as in Prometheus. One thread adds, any thread
/// reads; neither waits. A concurrent reader may miss the latest one.
class DurationHistogram {
 public:
  /// Upper bounds [us]; longer durations have a bucket of their own.
  static constexpr std::array<std::int64_t, 16> kBounds_us{
      5,    10,   20,     50,     100,    200,     500,     1'000,
      2000, 5000, 10'000, 20'000, 50'000, 100'000, 500'000, 1'000'000};

  struct Counts {
    std::array<std::uint64_t, kBounds_us.size() + 1> buckets{};  ///< not cumulative
    std::uint64_t count = 0;
    double sum_s = 0;
  };

  /// Thread: one at a time.
  void add(std::chrono::nanoseconds duration) {
    std::size_t bucket = 0;
    while (bucket < kBounds_us.size() && duration > std::chrono::microseconds(kBounds_us[bucket])) {
      ++bucket;
    }
    increase(buckets_[bucket], 1);
    increase(sum_ns_, static_cast<std::uint64_t>(duration.count() > 0 ? duration.count() : 0));
  }

  /// Thread: any.
  [[nodiscard]] Counts counts() const {
    Counts out;
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
      out.buckets[i] = buckets_[i].load(std::memory_order_relaxed);
      out.count += out.buckets[i];
    }
    out.sum_s = static_cast<double>(sum_ns_.load(std::memory_order_relaxed)) * 1e-9;
    return out;
  }

 private:
  // No other thread writes, so no locked instruction is needed.
  static void increase(std::atomic<std::uint64_t>& value, std::uint64_t by) {
    value.store(value.load(std::memory_order_relaxed) + by, std::memory_order_relaxed);
  }

  std::array<std::atomic<std::uint64_t>, kBounds_us.size() + 1> buckets_{};
  std::atomic<std::uint64_t> sum_ns_{0};
};

}  // namespace aprsim::api
