#include "world/base/usage/suggestion.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace aprsim::usage {
namespace {

TEST(EditDistance, CountsInsertionsDeletionsReplacementsAndSwaps) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("jog", ""), 3U);
  EXPECT_EQ(edit_distance("", "jog"), 3U);
  EXPECT_EQ(edit_distance("jog", "jog"), 0U);
  EXPECT_EQ(edit_distance("jg", "jog"), 1U);
  EXPECT_EQ(edit_distance("joog", "jog"), 1U);
  EXPECT_EQ(edit_distance("jag", "jog"), 1U);
  EXPECT_EQ(edit_distance("jgo", "jog"), 1U);
  EXPECT_EQ(edit_distance("ca", "abc"), 3U) << "as optimal string alignment has it";
}

TEST(Nearest, IsTheLikelyWord) {
  const std::vector<std::string> words = {"status", "step", "save", "speed", "conveyor"};
  EXPECT_EQ(nearest("stauts", words), "status");
  EXPECT_EQ(nearest("spede", words), "speed");
  EXPECT_EQ(nearest("sav", words), "save");
  EXPECT_EQ(nearest("conv", words), "conveyor") << "a beginning";
  EXPECT_EQ(nearest("quit", words), std::nullopt);
  EXPECT_EQ(nearest("", words), std::nullopt);
  EXPECT_EQ(nearest("s", words), std::nullopt);
  EXPECT_EQ(nearest(std::string(100000, 's'), words), std::nullopt);
  EXPECT_EQ(nearest("status", {}), std::nullopt);
}

}  // namespace
}  // namespace aprsim::usage
