#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace aprsim::server::journal {

/// Compares a recorded reply with a recomputed one, value by value. Thread: one at a time.
class Deviation {
 public:
  /// Compares numbers that JSON and XML preserve bit for bit.
  void number(std::string_view name, double then, double here) {
    if (then == here) return;
    const double by = std::abs(then - here);
    add(by / std::max(std::abs(then), std::abs(here)),
        [&] { return fmt::format("{} by {:.3g} (was {}, is {} here)", name, by, then, here); });
  }
  void word(std::string_view name, std::string_view then, std::string_view here) {
    if (then == here) return;
    add(1, [&] { return fmt::format("{} (was {}, is {} here)", name, then, here); });
  }

  [[nodiscard]] bool any() const { return count_ > 0; }
  /// Deviation of all values, each relative to its size.
  [[nodiscard]] double size() const { return size_; }
  /// Names the value that deviates most, and counts the others.
  [[nodiscard]] std::string text() const {
    return count_ > 1 ? fmt::format("{}, and {} other values", worst_, count_ - 1) : worst_;
  }

 private:
  template <typename Text>
  void add(double size, const Text& text) {
    ++count_;
    if (!std::isfinite(size)) size = 1;
    if (size > worst_size_) {
      worst_size_ = size;
      worst_ = text();
    }
    size_ += size;
  }

  std::string worst_;
  double worst_size_ = 0;  ///< relative to its size
  int count_ = 0;
  double size_ = 0;
};

}  // namespace aprsim::server::journal
