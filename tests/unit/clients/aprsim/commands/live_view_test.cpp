#include "clients/aprsim/commands/live_view.hpp"

#include <sstream>

#include <gtest/gtest.h>

namespace aprsim::client {
namespace {

TEST(LiveView, LinesAreCutByVisibleWidth) {
  EXPECT_EQ(cut_to_width("abcdef", 4), "abcd");
  EXPECT_EQ(cut_to_width("abc", 4), "abc");
  EXPECT_EQ(cut_to_width("", 4), "");
  // Colours count nothing, and end although the text is cut.
  EXPECT_EQ(cut_to_width("\x1b[31mabcdef\x1b[0m", 4), "\x1b[31mabcd\x1b[0m");
  EXPECT_EQ(cut_to_width("\xc3\xa4\xc3\xb6\xc3\xbc", 2), "\xc3\xa4\xc3\xb6") << "UTF-8";
  EXPECT_EQ(cut_to_width("ab\x1b[3", 4), "ab\x1b[3") << "a sequence that does not end";
}

TEST(LiveView, EachTextReplacesTheLast) {
  std::ostringstream out;
  LiveView view(out);
  view.show("one\ntwo\n", 24, 80);
  EXPECT_EQ(out.str(), "\rone\x1b[K\n\rtwo\x1b[K\n\x1b[J");
  out.str("");
  view.show("three\n", 24, 80);
  EXPECT_EQ(out.str(), "\x1b[2A\rthree\x1b[K\n\x1b[J");
  out.str("");
  view.show("four\n", 24, 80);
  EXPECT_EQ(out.str().substr(0, 4), "\x1b[1A");
}

TEST(LiveView, NothingScrolls) {
  std::ostringstream out;
  LiveView view(out);
  view.show("1\n2\n3\n4\n", 3, 80);
  EXPECT_EQ(out.str(), "\r1\x1b[K\n\r2\x1b[K\n\x1b[J");
}

}  // namespace
}  // namespace aprsim::client
