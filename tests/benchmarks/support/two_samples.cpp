#include "tests/benchmarks/support/two_samples.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>

namespace aprsim::bench {
namespace {

/// All runs of both samples by one measure.
class Ordered {
 public:
  explicit Ordered(const std::vector<double>& values) : order_(values.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::sort(order_.begin(), order_.end(),
              [&](std::size_t i, std::size_t k) { return values[i] < values[k]; });
    for (std::size_t i = 0; i < order_.size(); ++i) {
      last_.push_back(i + 1 == order_.size() || values[order_[i]] < values[order_[i + 1]]);
    }
  }
  /// Distance of the distribution functions of the runs that are `in_a` and the others.
  [[nodiscard]] double distance(const std::vector<char>& in_a, double a, double b) const {
    double apart = 0, most = 0;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      apart += in_a[order_[i]] != 0 ? 1 / a : -1 / b;
      if (last_[i] != 0) most = std::max(most, std::abs(apart));
    }
    return most;
  }

 private:
  std::vector<std::size_t> order_;
  std::vector<char> last_;  // of those that are equal
};

}  // namespace

TwoSamples compare(const std::vector<Measures>& a, const std::vector<Measures>& b,
                   unsigned permutations, unsigned seed) {
  if (a.empty() || b.empty()) throw std::invalid_argument("an empty sample");
  std::vector<Measures> all = a;
  all.insert(all.end(), b.begin(), b.end());
  const std::size_t measures = all.front().size();
  for (const auto& run : all) {
    if (run.size() != measures || run.empty()) throw std::invalid_argument("measures are missing");
  }
  std::vector<Ordered> ordered;
  for (std::size_t m = 0; m < measures; ++m) {
    std::vector<double> values;
    for (const auto& run : all) values.push_back(run[m]);
    ordered.emplace_back(values);
  }
  std::vector<char> in_a(all.size(), 0);
  std::fill_n(in_a.begin(), a.size(), char{1});
  const auto na = static_cast<double>(a.size()), nb = static_cast<double>(b.size());

  TwoSamples out;
  for (const auto& one : ordered) out.distances.push_back(one.distance(in_a, na, nb));
  const auto greatest = std::max_element(out.distances.begin(), out.distances.end());
  out.measure = static_cast<std::size_t>(greatest - out.distances.begin());
  out.distance = *greatest;

  constexpr double kRounding = 1e-9;
  std::mt19937_64 engine(seed);
  unsigned as_great = 0;
  for (unsigned i = 0; i < permutations; ++i) {
    // Fisher and Yates, by hand: std::shuffle differs between libraries.
    for (std::size_t k = in_a.size() - 1; k > 0; --k) std::swap(in_a[k], in_a[engine() % (k + 1)]);
    as_great += std::any_of(ordered.begin(), ordered.end(), [&](const Ordered& one) {
      return one.distance(in_a, na, nb) >= out.distance - kRounding;
    });
  }
  out.p = (as_great + 1.0) / (permutations + 1.0);
  return out;
}

}  // namespace aprsim::bench
