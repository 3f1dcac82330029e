#pragma once

#include <cstdint>
#include <optional>

/// Addresses of an FS100's signals and registers, as its I/O server checks them. Pure.
namespace aprsim::simple_message {

enum class IoSize : std::uint8_t { kBit, kGroup, kRegister };

/// Results of the I/O messages.
enum class IoResult : std::int32_t {
  kSuccess = 0,
  kNotReadable = 1001,
  kNotWritable = 1002,
  kValue = 1003,
};

inline constexpr std::int32_t kFirstRegister = 1'000'000;

/// Checks a read. `address` is as sent: of a group the bit address / 10; of a register its number,
/// to which 1 000 000 may be added.
[[nodiscard]] IoResult check_read(std::int32_t address, IoSize size);
[[nodiscard]] IoResult check_write(std::int32_t address, std::int32_t value, IoSize size);

/// The address under which a valid request's value is kept: of a group that of its first bit, of a
/// register kFirstRegister + its number.
[[nodiscard]] std::int32_t stored_address(std::int32_t address, IoSize size);

}  // namespace aprsim::simple_message
