#include "clients/aprsim/trace/alignment.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace aprsim::trace {
namespace {

constexpr std::size_t kMostCells = 100'000'000;
constexpr unsigned kFar = std::numeric_limits<unsigned>::max() / 4;

enum class Step : std::uint8_t { kNone, kPair, kOnlyA, kOnlyB };

using Cost = std::function<unsigned(std::size_t, std::size_t)>;

/// The table of one band: row i holds columns i + low to i + low + width - 1.
class Band {
 public:
  Band(std::size_t size_a, std::size_t size_b, std::size_t half_width)
      : size_a_(size_a), size_b_(size_b) {
    const auto a = static_cast<std::ptrdiff_t>(size_a), b = static_cast<std::ptrdiff_t>(size_b);
    const auto half = static_cast<std::ptrdiff_t>(half_width);
    low_ = std::max(std::min<std::ptrdiff_t>(0, b - a) - half, -a);
    width_ =
        static_cast<std::size_t>(std::min(std::max<std::ptrdiff_t>(0, b - a) + half, b) - low_ + 1);
  }

  [[nodiscard]] std::size_t cells() const { return (size_a_ + 1) * width_; }

  /// The least cost within the band.
  unsigned fill(const Cost& cost) {
    steps_.assign(cells(), Step::kNone);
    std::vector<unsigned> above(width_ + 1, kFar), row(width_ + 1, kFar);
    for (std::size_t i = 0; i <= size_a_; ++i) {
      std::ranges::fill(row, kFar);
      for (std::size_t k = 0; k < width_; ++k) {
        const std::ptrdiff_t column = static_cast<std::ptrdiff_t>(i + k) + low_;
        if (column < 0 || column > static_cast<std::ptrdiff_t>(size_b_)) continue;
        const auto j = static_cast<std::size_t>(column);
        unsigned best = i == 0 && j == 0 ? 0 : kFar;
        Step step = Step::kNone;
        const auto offer = [&](unsigned total, Step how) {
          if (total < best) {
            best = total;
            step = how;
          }
        };
        // Among equal paths prefer late gaps: of two equal elements the second counts as new.
        if (k > 0 && j > 0) offer(row[k - 1] + kGapCost, Step::kOnlyB);
        // The band moves by one column per row.
        if (i > 0) offer(above[k + 1] + kGapCost, Step::kOnlyA);
        if (i > 0 && j > 0) offer(above[k] + cost(i - 1, j - 1), Step::kPair);
        row[k] = best;
        steps_[i * width_ + k] = step;
      }
      std::swap(above, row);
    }
    return above[column_of_end()];
  }

  [[nodiscard]] std::vector<AlignedPair> path() const {
    std::vector<AlignedPair> out;
    std::size_t i = size_a_, j = size_b_;
    while (i > 0 || j > 0) {
      const auto k = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(j) -
                                              static_cast<std::ptrdiff_t>(i) - low_);
      switch (steps_[i * width_ + k]) {
        case Step::kPair:
          out.push_back({--i, --j});
          break;
        case Step::kOnlyA:
          out.push_back({--i, std::nullopt});
          break;
        default:
          out.push_back({std::nullopt, --j});
      }
    }
    std::ranges::reverse(out);
    return out;
  }

 private:
  [[nodiscard]] std::size_t column_of_end() const {
    return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(size_b_) -
                                    static_cast<std::ptrdiff_t>(size_a_) - low_);
  }

  std::size_t size_a_, size_b_, width_ = 0;
  std::ptrdiff_t low_ = 0;
  std::vector<Step> steps_;
};

}  // namespace

std::vector<AlignedPair> align(std::size_t size_a, std::size_t size_b, const Cost& cost) {
  const std::size_t widest = std::max(size_a, size_b);
  for (std::size_t half = 32;; half *= 4) {
    Band band(size_a, size_b, std::min(half, widest));
    const unsigned total = band.fill(cost);
    // Any path that leaves the band has more gaps than that.
    const bool is_best = half >= widest || total <= kGapCost * half;
    if (is_best || Band(size_a, size_b, std::min(half * 4, widest)).cells() > kMostCells) {
      return band.path();
    }
  }
}

}  // namespace aprsim::trace
