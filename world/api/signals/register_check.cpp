#include "world/api/signals/register_check.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

namespace aprsim::api {
namespace {

constexpr int kAddresses = 0x10000;

std::string text_of(double value) {
  std::array<char, 32> text{};
  const auto written = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), written.ptr};
}

std::string rounded(double value) {
  std::array<char, 32> text{};
  const auto written =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6);
  return {text.data(), written.ptr};
}

bool is_bit_area(RegisterArea area) {
  return area == RegisterArea::kCoil || area == RegisterArea::kDiscreteInput;
}

/// Counts that an encoding has.
std::pair<double, double> counts_of(RegisterEncoding encoding) {
  constexpr double kFloat = std::numeric_limits<float>::max();
  switch (encoding) {
    case RegisterEncoding::kBit:
      return {0, 1};
    case RegisterEncoding::kUint16:
      return {0, 65535};
    case RegisterEncoding::kInt16:
      return {-32768, 32767};
    case RegisterEncoding::kUint32:
      return {0, 4294967295.0};
    case RegisterEncoding::kInt32:
      return {-2147483648.0, 2147483647};
    case RegisterEncoding::kFloat32:
      break;
  }
  return {-kFloat, kFloat};
}

}  // namespace

std::optional<RegisterProblem> check_register(const Register& mapped) {
  const bool bit = mapped.encoding == RegisterEncoding::kBit;
  if (bit != is_bit_area(mapped.area)) {
    return RegisterProblem{"encoding", bit ? "bit" : "numbers",
                           bit ? "numbers: input and holding registers have 16 bits"
                               : "bit: coils and discrete inputs have no other encoding"};
  }
  if (bit && (mapped.scale != 1 || mapped.offset != 0)) {
    return RegisterProblem{mapped.scale != 1 ? "scale" : "offset",
                           text_of(mapped.scale != 1 ? mapped.scale : mapped.offset),
                           "none: a bit is 0 or 1"};
  }
  if (mapped.address + mapped.words() > kAddresses) {
    return RegisterProblem{"address", std::to_string(mapped.address),
                           "at most 65534: the value takes two registers"};
  }
  const bool takes_writes =
      mapped.area == RegisterArea::kCoil || mapped.area == RegisterArea::kHoldingRegister;
  if (mapped.writable && !takes_writes) {
    return RegisterProblem{"access", "write", "read: only coils and holding registers are written"};
  }
  return std::nullopt;
}

std::optional<RegisterProblem> check_binding(const Register& mapped, const BoundSignal& signal) {
  if (mapped.writable && !signal.writable) {
    return RegisterProblem{"access", "write", "read: " + mapped.signal + " is only read"};
  }
  if (!mapped.writable && signal.info->use == SignalUse::kWrite) {
    return RegisterProblem{"access", "read", "write: " + mapped.signal + " is only written"};
  }
  if (!signal.has_range()) return std::nullopt;
  if (mapped.encoding == RegisterEncoding::kBit) {
    const bool fits = signal.min <= 0 && signal.max >= 1;
    if (fits || !mapped.writable) return std::nullopt;
    return RegisterProblem{"encoding", "bit",
                           "a signal that can be 0 and 1; " + mapped.signal + " has " +
                               text_of(signal.min) + " to " + text_of(signal.max)};
  }
  const auto [low, high] = counts_of(mapped.encoding);
  for (const double value : {signal.min, signal.max}) {
    const double count = (value - mapped.offset) / mapped.scale;
    // A register rounds to the nearest count.
    if (count > low - 0.5 && count < high + 0.5) continue;
    return RegisterProblem{"scale", text_of(mapped.scale),
                           "one with which the encoding holds " + text_of(signal.min) + " to " +
                               text_of(signal.max) + " of " + mapped.signal + "; " +
                               text_of(value) + " would be the count " + rounded(count)};
  }
  return std::nullopt;
}

}  // namespace aprsim::api
