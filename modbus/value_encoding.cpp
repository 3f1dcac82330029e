#include "modbus/value_encoding.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace aprsim::modbus {
namespace {

/// The greatest and least counts of an integer encoding.
std::pair<double, double> range_of(NumberEncoding encoding) {
  switch (encoding) {
    case NumberEncoding::kUint16:
      return {0, 65535};
    case NumberEncoding::kInt16:
      return {-32768, 32767};
    case NumberEncoding::kUint32:
      return {0, 4294967295.0};
    case NumberEncoding::kInt32:
      return {-2147483648.0, 2147483647};
    default:
      return {0, 1};
  }
}

/// The nearest count in two's complement.
std::uint32_t integer_of(double count, const ValueFormat& format) {
  constexpr double kMost = 9e15;  // beyond it a double does not resolve counts
  const auto [low, high] = range_of(format.encoding);
  if (!format.wraps || !(std::abs(count) < kMost)) count = std::clamp(count, low, high);
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(std::llround(count)) & 0xFFFFFFFFU);
}

std::uint32_t float_of(double count) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return std::bit_cast<std::uint32_t>(static_cast<float>(std::clamp(count, -kMost, kMost)));
}

}  // namespace

ValueWords to_words(double value, const ValueFormat& format) {
  if (format.encoding == NumberEncoding::kBit) {
    return {static_cast<std::uint16_t>(value != 0 && !std::isnan(value) ? 1 : 0), 0};
  }
  double count = (value - format.offset) / format.scale;
  if (std::isnan(count)) count = 0;
  const std::uint32_t bits =
      format.encoding == NumberEncoding::kFloat32 ? float_of(count) : integer_of(count, format);
  const auto high = static_cast<std::uint16_t>(bits >> 16U);
  const auto low = static_cast<std::uint16_t>(bits & 0xFFFFU);
  if (format.words() == 1) return {low, 0};
  return format.low_word_first ? ValueWords{low, high} : ValueWords{high, low};
}

std::optional<double> from_words(const ValueWords& words, const ValueFormat& format) {
  const std::uint32_t high = words[format.low_word_first ? 1 : 0];
  const std::uint32_t low = words[format.low_word_first ? 0 : 1];
  const std::uint32_t both = (high << 16U) | low;
  double count = words[0];
  switch (format.encoding) {
    case NumberEncoding::kBit:
    case NumberEncoding::kUint16:
      break;
    case NumberEncoding::kInt16:
      count = static_cast<std::int16_t>(words[0]);
      break;
    case NumberEncoding::kUint32:
      count = both;
      break;
    case NumberEncoding::kInt32:
      count = static_cast<std::int32_t>(both);
      break;
    case NumberEncoding::kFloat32:
      count = std::bit_cast<float>(both);
      break;
  }
  if (!std::isfinite(count)) return std::nullopt;
  return count * format.scale + format.offset;
}

}  // namespace aprsim::modbus
