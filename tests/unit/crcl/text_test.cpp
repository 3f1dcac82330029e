#include "crcl/text.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>
#include <rapidcheck.h>

namespace aprsim::crcl {
namespace {

std::string formatted(double value) {
  std::string out;
  append_double(out, value);
  return out;
}

std::string escaped(std::string_view text) {
  std::string out;
  append_escaped(out, text);
  return out;
}

TEST(Text, ReadsTheLexicalFormsOfDouble) {
  EXPECT_EQ(parse_double(" 1.5\n"), 1.5);
  EXPECT_EQ(parse_double("+1.5"), 1.5);
  EXPECT_EQ(parse_double("-.5"), -0.5);
  EXPECT_EQ(parse_double("1."), 1.0);
  EXPECT_EQ(parse_double("1.2246467991473532E-16"), 1.2246467991473532e-16);
  EXPECT_EQ(parse_double("INF"), HUGE_VAL);
  EXPECT_EQ(parse_double("-INF"), -HUGE_VAL);
  EXPECT_TRUE(std::isnan(parse_double("NaN").value()));
}

TEST(Text, RefusesWhatIsNoDouble) {
  for (const char* text : {"", " ", "inf", "nan", "infinity", "0x10", "1,5", "1 2", "1e", "+-1",
                           "++1", "1e999", "."}) {
    EXPECT_FALSE(parse_double(text)) << text;
  }
}

TEST(Text, ReadsIntegersAndBooleans) {
  EXPECT_EQ(parse_long("9223372036854775807"), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(parse_long(" -7 "), -7);
  EXPECT_FALSE(parse_long("9223372036854775808"));
  EXPECT_FALSE(parse_long("1.0"));
  EXPECT_EQ(parse_int("+12"), 12);
  EXPECT_FALSE(parse_int("2147483648"));
  EXPECT_EQ(parse_bool("1"), true);
  EXPECT_EQ(parse_bool(" false "), false);
  EXPECT_FALSE(parse_bool("TRUE"));
}

TEST(Text, DoublesComeBackBitForBit) {
  EXPECT_TRUE(rc::check("append_double then parse_double", [](std::uint64_t bits) {
    const auto value = std::bit_cast<double>(bits);
    const double back = parse_double(formatted(value)).value();
    const bool same =
        std::isnan(value) ? std::isnan(back) : std::bit_cast<std::uint64_t>(back) == bits;
    RC_ASSERT(same);
  }));
}

TEST(Text, DoublesAreShort) {
  EXPECT_EQ(formatted(250), "250");
  EXPECT_EQ(formatted(0.1), "0.1");
  EXPECT_EQ(formatted(-0.0), "-0");
  EXPECT_EQ(formatted(HUGE_VAL), "INF");
}

TEST(Text, EscapesMarkup) {
  EXPECT_EQ(escaped("a<b>&\"c\r\n"), "a&lt;b&gt;&amp;&quot;c&#13;\n");
  EXPECT_EQ(escaped("Zahnr\xC3\xA4"
                    "der \xF0\x9F\xA6\xBE"),
            "Zahnr\xC3\xA4"
            "der \xF0\x9F\xA6\xBE");
}

TEST(Text, ReplacesWhatXmlCannotHold) {
  const std::string r = "\xEF\xBF\xBD";
  EXPECT_EQ(escaped(std::string_view("a\0b", 3)), "a" + r + "b");
  EXPECT_EQ(escaped("\x1B"), r);
  EXPECT_EQ(escaped("\xC3"), r);                  // cut off
  EXPECT_EQ(escaped("\x80z"), r + "z");           // continuation alone
  EXPECT_EQ(escaped("\xC0\xAF"), r + r);          // overlong
  EXPECT_EQ(escaped("\xED\xA0\x80"), r + r + r);  // surrogate
  EXPECT_EQ(escaped("\xEF\xBF\xBE"), r + r + r);  // U+FFFE
}

TEST(Text, ShortensAtACharacter) {
  EXPECT_EQ(shorten("abc", 3), "abc");
  EXPECT_EQ(shorten("abcd", 3), "abc...");
  EXPECT_EQ(shorten("ab\xC3\xA4", 3), "ab...");
}

}  // namespace
}  // namespace aprsim::crcl
