#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace aprsim::render {

/// Counts memory against a limit before it is allocated. Thread: one at a time.
class MemoryBudget {
 public:
  void set_limit(std::uint64_t bytes) {
    limit_ = bytes;
    exceeded_ = false;
  }
  [[nodiscard]] std::uint64_t used() const { return used_; }
  /// Whether something has been refused since the limit was set.
  [[nodiscard]] bool exceeded() const { return exceeded_; }

  /// False where the limit would be exceeded.
  [[nodiscard]] bool take(std::uint64_t bytes) {
    exceeded_ = exceeded_ || bytes > limit_ || used_ > limit_ - bytes;
    if (!exceeded_) used_ += bytes;
    return !exceeded_;
  }
  void give(std::uint64_t bytes) { used_ -= bytes; }

  /// Empties a list and makes room for `size` values. False where the limit would be exceeded.
  template <typename T>
  [[nodiscard]] bool make_room(std::vector<T>& list, std::size_t size) {
    list.clear();
    if (size <= list.capacity()) return true;
    give(list.capacity() * sizeof(T));
    std::vector<T>().swap(list);
    if (!take(size * sizeof(T))) return false;
    list.reserve(size);
    return true;
  }

 private:
  std::uint64_t limit_ = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t used_ = 0;
  bool exceeded_ = false;
};

}  // namespace aprsim::render
