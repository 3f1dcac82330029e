// Values as words and back, over random values and formats.

#include "modbus/value_encoding.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::modbus {
namespace {

constexpr std::array kIntegers{NumberEncoding::kUint16, NumberEncoding::kInt16,
                               NumberEncoding::kUint32, NumberEncoding::kInt32};

struct Limits {
  double low, high;
};
Limits limits_of(NumberEncoding encoding) {
  switch (encoding) {
    case NumberEncoding::kUint16:
      return {0, 65535};
    case NumberEncoding::kInt16:
      return {-32768, 32767};
    case NumberEncoding::kUint32:
      return {0, 4294967295.0};
    default:
      return {-2147483648.0, 2147483647.0};
  }
}

ValueFormat format_of(NumberEncoding encoding, std::mt19937_64& random) {
  std::uniform_real_distribution<double> exponent(-4, 3), offset(-100, 100);
  std::bernoulli_distribution coin(0.5);
  const double scale = std::pow(10, exponent(random));
  return {.encoding = encoding,
          .low_word_first = coin(random),
          .scale = coin(random) ? scale : -scale,
          .offset = offset(random)};
}

TEST(ValueEncoding, CountsOfIntegersComeBackAsTheyWere) {
  std::mt19937_64 random(48);
  for (int i = 0; i < 20'000; ++i) {
    const NumberEncoding encoding = kIntegers[static_cast<std::size_t>(i) % kIntegers.size()];
    const ValueFormat format = format_of(encoding, random);
    const auto [low, high] = limits_of(encoding);
    const double count = std::round(std::uniform_real_distribution<double>(low, high)(random));
    const double value = count * format.scale + format.offset;
    const auto read = from_words(to_words(value, format), format);
    ASSERT_TRUE(read.has_value());
    // The nearest count, which the sum's rounding does not change.
    EXPECT_NEAR(*read, value, 1e-9 * (std::abs(value) + 100)) << i;
    EXPECT_EQ(to_words(*read, format), to_words(value, format)) << i;
  }
}

TEST(ValueEncoding, AnyValueIsRoundedToTheNearestCountAndSaturates) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20'000; ++i) {
    const NumberEncoding encoding = kIntegers[static_cast<std::size_t>(i) % kIntegers.size()];
    const ValueFormat format = format_of(encoding, random);
    const auto [low, high] = limits_of(encoding);
    const double wide = high - low;
    const double count = std::uniform_real_distribution<double>(low - wide, high + wide)(random);
    const auto read = from_words(to_words(count * format.scale + format.offset, format), format);
    ASSERT_TRUE(read.has_value());
    const double got = (*read - format.offset) / format.scale;
    EXPECT_NEAR(got, std::clamp(count, low, high), 0.5 + 1e-3) << i;
  }
}

TEST(ValueEncoding, FloatsComeBackWithTheirPrecision) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-30, 30), mantissa(-1, 1);
  for (int i = 0; i < 20'000; ++i) {
    const ValueFormat format{.encoding = NumberEncoding::kFloat32, .low_word_first = i % 2 == 1};
    const double value = mantissa(random) * std::pow(10, exponent(random));
    const auto read = from_words(to_words(value, format), format);
    ASSERT_TRUE(read.has_value());
    EXPECT_EQ(*read, static_cast<double>(static_cast<float>(value))) << i;
  }
}

TEST(ValueEncoding, WordsAreInTheirOrder) {
  ValueFormat format{.encoding = NumberEncoding::kUint32};
  EXPECT_EQ(to_words(0x12345678, format), (ValueWords{0x1234, 0x5678}));
  format.low_word_first = true;
  EXPECT_EQ(to_words(0x12345678, format), (ValueWords{0x5678, 0x1234}));
  EXPECT_EQ(from_words({0x5678, 0x1234}, format), 0x12345678);
  // 1.0 as IEEE 754 has it.
  format = {.encoding = NumberEncoding::kFloat32};
  EXPECT_EQ(to_words(1, format), (ValueWords{0x3F80, 0}));
  format.low_word_first = true;
  EXPECT_EQ(to_words(1, format), (ValueWords{0, 0x3F80}));
}

TEST(ValueEncoding, CountersWrapAndNumbersThatAreNoneAreZero) {
  const double kNan = std::numeric_limits<double>::quiet_NaN();
  ValueFormat format{.encoding = NumberEncoding::kUint16, .wraps = true};
  EXPECT_EQ(to_words(65536 + 5, format)[0], 5);
  EXPECT_EQ(to_words(-1, format)[0], 0xFFFF);
  EXPECT_EQ(to_words(1e300, format)[0], 0xFFFF) << "beyond what a double counts it saturates";
  EXPECT_EQ(to_words(kNan, format)[0], 0);
  format = {.encoding = NumberEncoding::kInt32, .wraps = true};
  EXPECT_EQ(to_words(2147483648.0, format), (ValueWords{0x8000, 0}));
  format = {.encoding = NumberEncoding::kBit};
  EXPECT_EQ(to_words(kNan, format)[0], 0);
  EXPECT_EQ(to_words(0.2, format)[0], 1);
  format = {.encoding = NumberEncoding::kFloat32};
  EXPECT_EQ(from_words({0x7F80, 0}, format), std::nullopt) << "infinity";
  EXPECT_EQ(from_words({0x7FC0, 0}, format), std::nullopt) << "NaN";
  const auto greatest = from_words(to_words(1e300, format), format);
  EXPECT_EQ(greatest, static_cast<double>(std::numeric_limits<float>::max()));
}

}  // namespace
}  // namespace aprsim::modbus
