#include "protocols/simple_message/codec/io_address.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace aprsim::simple_message {
namespace {

struct Range {
  std::int32_t first, last;
};

constexpr std::array<Range, 3> kWritable{{
    {10010, 11287},  // general outputs
    {25010, 26287},  // network inputs
    {60010, 60647},  // interface panel
}};
constexpr std::array<Range, 9> kReadable{{
    {10, 1287},      // general inputs
    {20010, 21287},  // external inputs
    {30010, 31287},  // external outputs
    {35010, 36287},  // network outputs
    {40010, 41607},  // specific inputs
    {50010, 52007},  // specific outputs
    {70010, 79997},  // auxiliary relays
    {80010, 80647},  // control status
    {82010, 82207},  // pseudo inputs
}};
constexpr std::int32_t kRegisters = 1000, kWritableRegisters = 560;

template <std::size_t size>
bool within(const std::array<Range, size>& ranges, std::int32_t address) {
  return std::ranges::any_of(
      ranges, [&](const Range& range) { return address >= range.first && address <= range.last; });
}

/// Signals are numbered in groups of eight: no address ends in 8 or 9.
bool is_signal(std::int32_t address) { return address % 10 <= 7; }

}  // namespace

std::int32_t stored_address(std::int32_t address, IoSize size) {
  if (size == IoSize::kGroup) {
    constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max() / 10;
    return address < 0 || address > kMost ? -1 : address * 10;
  }
  if (size == IoSize::kRegister && address >= 0 && address < kFirstRegister) {
    return kFirstRegister + address;
  }
  return address;
}

IoResult check_read(std::int32_t address, IoSize size) {
  const std::int32_t at = stored_address(address, size);
  if (size == IoSize::kRegister) {
    const bool there = at >= kFirstRegister && at < kFirstRegister + kRegisters;
    return there ? IoResult::kSuccess : IoResult::kNotReadable;
  }
  const bool there = (within(kReadable, at) || within(kWritable, at)) && is_signal(at);
  return there ? IoResult::kSuccess : IoResult::kNotReadable;
}

IoResult check_write(std::int32_t address, std::int32_t value, IoSize size) {
  const std::int32_t at = stored_address(address, size);
  const bool there = size == IoSize::kRegister
                         ? at >= kFirstRegister && at < kFirstRegister + kWritableRegisters
                         : within(kWritable, at) && is_signal(at);
  if (!there) return IoResult::kNotWritable;
  const std::int32_t most = size == IoSize::kRegister ? 0xFFFF : size == IoSize::kGroup ? 0xFF : 1;
  return value < 0 || value > most ? IoResult::kValue : IoResult::kSuccess;
}

}  // namespace aprsim::simple_message
