#include "clients/aprsim/trace/alignment.hpp"

#include <random>
#include <string>

#include <gtest/gtest.h>

namespace aprsim::trace {
namespace {

/// Characters that are the same cost nothing, others of a kind (upper or lower case) something.
unsigned cost_of(char a, char b) {
  if (a == b) return 0;
  return (std::isupper(a) != 0) == (std::isupper(b) != 0) ? 5U : kNeverPaired;
}

std::vector<AlignedPair> aligned(const std::string& a, const std::string& b) {
  return align(a.size(), b.size(),
               [&](std::size_t i, std::size_t j) { return cost_of(a[i], b[j]); });
}

std::string shown(const std::string& a, const std::string& b) {
  std::string out;
  for (const auto& pair : aligned(a, b)) {
    out += std::string(1, pair.a ? a[*pair.a] : '-') + (pair.b ? b[*pair.b] : '-') + ' ';
  }
  return out;
}

/// The least cost by the plain table of all places.
unsigned least_cost(const std::string& a, const std::string& b) {
  std::vector<std::vector<unsigned>> table(a.size() + 1, std::vector<unsigned>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        table[i][j] = static_cast<unsigned>(i + j) * kGapCost;
        continue;
      }
      table[i][j] = std::min({table[i - 1][j - 1] + cost_of(a[i - 1], b[j - 1]),
                              table[i - 1][j] + kGapCost, table[i][j - 1] + kGapCost});
    }
  }
  return table[a.size()][b.size()];
}

TEST(Alignment, PairsEqualElementsAndMarksGaps) {
  EXPECT_EQ(shown("abc", "abc"), "aa bb cc ");
  EXPECT_EQ(shown("abc", "ac"), "aa b- cc ");
  EXPECT_EQ(shown("ac", "abc"), "aa -b cc ");
  EXPECT_EQ(shown("abc", "axc"), "aa bx cc ");
  EXPECT_EQ(shown("aBc", "axc"), "aa B- -x cc ");
  EXPECT_EQ(shown("", "ab"), "-a -b ");
  EXPECT_EQ(shown("ab", ""), "a- b- ");
  EXPECT_EQ(shown("", ""), "");
}

TEST(Alignment, FindsTheLeastCostForAllSizes) {
  std::mt19937 random(5);
  const std::string letters = "abcABC";
  for (int round = 0; round < 200; ++round) {
    std::string a(random() % 120, ' '), b;
    for (char& c : a) c = letters[random() % letters.size()];
    // Some pairs are a text and its changed copy, some are two different texts.
    b = a;
    if (round % 3 == 0) b.assign(random() % 300, 'a');
    for (int change = 0; change < round % 50 && !b.empty(); ++change) {
      const std::size_t at = random() % b.size();
      if (random() % 2 == 0)
        b.erase(at, 1);
      else
        b.insert(at, 1, letters[random() % letters.size()]);
    }
    unsigned total = 0;
    std::size_t i = 0, j = 0;
    for (const auto& pair : aligned(a, b)) {
      if (pair.a) {
        EXPECT_EQ(*pair.a, i++);
      }
      if (pair.b) {
        EXPECT_EQ(*pair.b, j++);
      }
      total += pair.a && pair.b ? cost_of(a[*pair.a], b[*pair.b]) : kGapCost;
    }
    EXPECT_EQ(i, a.size());
    EXPECT_EQ(j, b.size());
    EXPECT_EQ(total, least_cost(a, b)) << a << " and " << b;
  }
}

}  // namespace
}  // namespace aprsim::trace
