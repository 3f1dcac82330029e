#include "world/base/yaml/yaml_reader.hpp"

#include <chrono>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/support/patience.hpp"

namespace aprsim::yaml {
namespace {

Document parsed(const std::string& text) {
  auto document = Document::from_text(text, "test.yaml");
  EXPECT_TRUE(document.has_value()) << document.error().message;
  return std::move(*document);
}

TEST(YamlReader, ReadsEveryType) {
  const Document document = parsed(
      "number: -2.5e-1\nplus: +3\nwhole: 42\nflag: true\ntext: 'a b'\nword: two\nlist: [1, 2, 3]\n"
      "inner: {a: 1}\n");
  const Map map =
      document.root().map({"number", "plus", "whole", "flag", "text", "word", "list", "inner"});
  EXPECT_EQ(map["number"].number(), -0.25);
  EXPECT_EQ(map["plus"].number(), 3);
  EXPECT_EQ(map["whole"].integer(), 42);
  EXPECT_TRUE(map["flag"].boolean());
  EXPECT_EQ(map["text"].text(), "a b");
  EXPECT_EQ(map["word"].word({"one", "two"}), 1u);
  EXPECT_EQ(map["list"].numbers<3>(), (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(map["inner"].map({"a", "b"})["a"].integer(), 1);
  EXPECT_EQ(map["inner"].map({"a", "b"})["b"].key(), "inner.b");
  EXPECT_FALSE(document.error());
}

TEST(YamlReader, WholeNumbersMayBeHexadecimal) {
  const Document document = parsed("a: 0x8000\nb: 0xFf\n");
  const Map map = document.root().map({"a", "b"});
  EXPECT_EQ(map["a"].integer(), 0x8000);
  EXPECT_EQ(map["b"].integer(), 255);
  EXPECT_FALSE(document.error());
  for (const char* wrong : {"0x", "0X10", "-0x1", "+0x1", "0x1g", "0x1FFFFFFFF", "'0x10'", "x10"}) {
    const Document refused = parsed(std::string("a: ") + wrong + "\n");
    EXPECT_EQ(refused.root().map({"a"})["a"].integer(), 0) << wrong;
    EXPECT_TRUE(refused.error()) << wrong;
  }
}

TEST(YamlReader, FallbacksServeAbsentKeysOnly) {
  const Document document = parsed("there: 5\n");
  const Map map = document.root().map({"there", "absent"});
  EXPECT_EQ(map["there"].number_or(1), 5);
  EXPECT_EQ(map["absent"].number_or(1), 1);
  EXPECT_EQ(map["absent"].integer_or(2), 2);
  EXPECT_TRUE(map["absent"].boolean_or(true));
  EXPECT_EQ(map["absent"].text_or("x"), "x");
  EXPECT_EQ(map["absent"].word_or(1, {"one", "two"}), 1u);
  EXPECT_TRUE(map["absent"].items().empty());
  EXPECT_TRUE(map["absent"].entries().empty());
  EXPECT_FALSE(map["absent"]);
  EXPECT_FALSE(document.error());
}

TEST(YamlReader, FirstErrorSticks) {
  const Document document = parsed("a: x\nb: y\n");
  const Map map = document.root().map({"a", "b"});
  EXPECT_EQ(map["a"].number(), 0);
  EXPECT_EQ(map["b"].number(), 0);
  ASSERT_TRUE(document.error());
  EXPECT_EQ(document.error()->field, "a");
  EXPECT_EQ(document.error()->message, "test.yaml:1:4: a: found \"x\", expected a number");
}

TEST(YamlReader, RangesSayTheirLimits) {
  EXPECT_EQ(above(0).text(), " > 0");
  EXPECT_EQ(at_least(-1.5).text(), " >= -1.5");
  EXPECT_EQ(between(0, 1).text(), " in [0, 1]");
  EXPECT_EQ((Range{.max = 4, .open_max = true}).text(), " < 4");
  EXPECT_EQ(Range{}.text(), "");
  EXPECT_TRUE(above(0).holds(1e-300));
  EXPECT_FALSE(above(0).holds(0));
  EXPECT_TRUE(between(0, 1).holds(1));
}

TEST(YamlReader, NumbersAreExact) {
  const Document document = parsed("a: 0.1\nb: 123456789012345678\nc: 5e-324\n");
  const Map map = document.root().map({"a", "b", "c"});
  EXPECT_EQ(map["a"].number(), 0.1);
  EXPECT_EQ(map["b"].integer(), 123456789012345678);
  EXPECT_EQ(map["c"].number(), 5e-324);
  EXPECT_FALSE(document.error()) << document.error()->message;
}

TEST(YamlReader, ThingsThatOnlyLookLikeNumbers) {
  for (const char* text : {"0x10", "1_000", "1,5", "1e", ".nan", "-.inf", "+-1", "12abc", "--1"}) {
    const Document document = parsed(std::string("a: ") + text + "\n");
    static_cast<void>(document.root().map({"a"})["a"].number());
    EXPECT_TRUE(document.error()) << text;
  }
}

TEST(YamlReader, AskingForAKeyThatWasNotDeclaredIsABug) {
  const Document document = parsed("a: 1\n");
  const Map map = document.root().map({"a"});
  EXPECT_THROW(static_cast<void>(map["b"]), std::logic_error);
}

TEST(YamlReader, LongTextIsCutInMessages) {
  const Document document = parsed("a: " + std::string(1000, 'x') + "\n");
  static_cast<void>(document.root().map({"a"})["a"].number());
  ASSERT_TRUE(document.error());
  EXPECT_LT(document.error()->message.size(), 150u);
}

TEST(YamlReader, DeepNestingIsRefused) {
  const auto document = Document::from_text(std::string(100000, '['), "deep.yaml");
  ASSERT_FALSE(document.has_value());
  EXPECT_EQ(document.error().message.rfind("deep.yaml:1:", 0), 0u) << document.error().message;
}

/// The error of a text, found in a time that grows with its size only.
std::string refusal(const std::string& text) {
  const auto began = std::chrono::steady_clock::now();
  const auto document = Document::from_text(text, "big.yaml");
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(10) * test::kPatience);
  return document ? "" : document.error().message;
}

TEST(YamlReader, RefusesOversizedInputQuicklyWithTheNumber) {
  std::string keys, flow = "{";
  for (int i = 0; i < 60'000; ++i) {
    keys += "key_" + std::to_string(i) + ": 1\n";
    flow += "key_" + std::to_string(i) + ": 1, ";
  }
  EXPECT_EQ(refusal(keys), "big.yaml:1001:1: found 1001 keys in a map, expected at most 1000");
  EXPECT_NE(refusal(flow + "}").find("found 1001 keys in a map, expected at most 1000"),
            std::string::npos);
  EXPECT_EQ(refusal(std::string(40, '[') + std::string(40, ']')),
            "big.yaml:1:33: found 33 levels of lists and maps, expected at most 32");
  std::string list;
  for (int i = 0; i < 201'000; ++i) list += "-\n";
  EXPECT_NE(refusal(list).find("found 200001 values, expected at most 200000"), std::string::npos);
}

TEST(YamlReader, EmptyFileIsNotAMap) {
  const Document document = parsed("");
  static_cast<void>(document.root().map({"a"}));
  ASSERT_TRUE(document.error());
  EXPECT_EQ(document.error()->message,
            "test.yaml:1:1: found nothing, expected a map with the keys a");
}

TEST(YamlReader, SetReplacesAndMakesValues) {
  Document document = parsed("modbus: {port: 502}\n");
  ASSERT_TRUE(document.set("modbus.port", "1502", "--set"));
  ASSERT_TRUE(document.set("log.level", "debug", "--set"));
  ASSERT_TRUE(document.set("list", "[1, 2]", "--set"));
  const Map map = document.root().map({"modbus", "log", "list"});
  EXPECT_EQ(map["modbus"].map({"port"})["port"].integer(), 1502);
  EXPECT_EQ(map["log"].map({"level"})["level"].text(), "debug");
  EXPECT_EQ(map["list"].numbers<2>(), (std::array<double, 2>{1, 2}));
  EXPECT_FALSE(document.error());
}

TEST(YamlReader, SetValuesAreNamedByTheirSource) {
  Document document = parsed("modbus: {port: 502}\n");
  ASSERT_TRUE(document.set("modbus.port", "many", "--set"));
  static_cast<void>(
      document.root().map({"modbus"})["modbus"].map({"port"})["port"].integer(0, 65535));
  ASSERT_TRUE(document.error());
  EXPECT_EQ(document.error()->message,
            "--set:1:1: modbus.port: found \"many\", expected a whole number in [0, 65535]");
}

TEST(YamlReader, SetRefusesPathsThroughOtherThings) {
  Document document = parsed("port: 502\nlist: [1]\n");
  EXPECT_FALSE(document.set("port.number", "1", "--set"));
  EXPECT_FALSE(document.set("list.0", "1", "--set"));
  EXPECT_FALSE(document.set("", "1", "--set"));
  EXPECT_FALSE(document.set("a..b", "1", "--set"));
  const auto unparsed = document.set("port", "[1", "--set");
  EXPECT_FALSE(unparsed.has_value());
  const Map map = document.root().map({"port", "list"});
  EXPECT_EQ(map["port"].integer(), 502);
}

TEST(YamlReader, NearestWordNeedsToBeNear) {
  const std::vector<std::string> known{"max_speed", "length", "width"};
  EXPECT_EQ(nearest_word("max_sped", known), "max_speed");
  EXPECT_EQ(nearest_word("lenght", known), "length");
  EXPECT_EQ(nearest_word("zebra", known), "");
  EXPECT_EQ(nearest_word("", known), "");
}

}  // namespace
}  // namespace aprsim::yaml
