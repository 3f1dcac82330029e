#pragma once

#include <array>
#include <cstdint>
#include <optional>

/// Values of signals as words of registers, and back: value = count * scale + offset.
namespace aprsim::modbus {

enum class NumberEncoding : std::uint8_t { kBit, kUint16, kInt16, kUint32, kInt32, kFloat32 };

struct ValueFormat {
  NumberEncoding encoding = NumberEncoding::kUint16;
  bool low_word_first = false;  ///< of 32-bit values
  double scale = 1, offset = 0;
  bool wraps = false;  ///< an integer beyond the encoding's range wraps; else it saturates

  /// Registers that a value takes.
  [[nodiscard]] constexpr int words() const { return encoding >= NumberEncoding::kUint32 ? 2 : 1; }
};

using ValueWords = std::array<std::uint16_t, 2>;  ///< by address; one word: the second is 0

/// Words of the nearest count. NaN gives the count 0.
[[nodiscard]] ValueWords to_words(double value, const ValueFormat& format);

/// The value of the words; absent where they are a float that is not finite.
[[nodiscard]] std::optional<double> from_words(const ValueWords& words, const ValueFormat& format);

}  // namespace aprsim::modbus
