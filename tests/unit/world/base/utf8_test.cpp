#include "world/base/utf8.hpp"

#include <gtest/gtest.h>

namespace aprsim::utf8 {
namespace {

TEST(Utf8, KnowsWellFormedCharacters) {
  for (const char* text :
       {"", "a", "\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x98\x80", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_TRUE(is_valid(text)) << text;
  }
  // A lone continuation, cut characters, overlong forms, a surrogate, beyond U+10FFFF.
  for (const char* text : {"\x80", "\xc3", "\xe2\x82", "\xf0\x9f\x98", "\xc0\xaf", "\xe0\x80\x80",
                           "\xf0\x80\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xff"}) {
    EXPECT_FALSE(is_valid(text));
  }
}

TEST(Utf8, EscapesBytesThatAreNone) {
  EXPECT_EQ(valid("lab\xff \xc3\xa9 \xe2\x82"), "lab\\xff \xc3\xa9 \\xe2\\x82");
  EXPECT_TRUE(is_valid(valid("\xed\xa0\x80\xf4\x90")));
}

TEST(Utf8, EscapesControlCharacters) {
  EXPECT_EQ(printable("a\x1b[2Jb"), "a\\x1b[2Jb");
  EXPECT_EQ(printable("\x9b"
                      "2J"),
            "\\x9b2J");
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J"),
            "\\xc2\\x9b2J")
      << "the CSI of C1 in UTF-8";
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "gnp"),
            "\\xe2\\x80\\xaegnp")
      << "text direction";
  EXPECT_EQ(printable("a\tb\nc\x7f", "\n\t"), "a\tb\nc\\x7f");
  EXPECT_EQ(printable("caf\xc3\xa9"), "caf\xc3\xa9");
}

TEST(Utf8, CutsBetweenCharacters) {
  const std::string text =
      "ab\xe2\x82\xac"
      "d";
  EXPECT_EQ(cut(text, 6), text);
  EXPECT_EQ(cut(text, 5), "ab\xe2\x82\xac");
  EXPECT_EQ(cut(text, 4), "ab");
  EXPECT_EQ(cut(text, 3), "ab");
  EXPECT_EQ(cut(text, 2), "ab");
  EXPECT_EQ(cut(text, 0), "");
}

}  // namespace
}  // namespace aprsim::utf8
