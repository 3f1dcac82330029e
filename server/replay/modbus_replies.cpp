#include "server/replay/modbus_replies.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "modbus/request_validator.hpp"

namespace aprsim::server::journal {
namespace {

using modbus::Area;
using modbus::Function;

constexpr std::size_t kFunctionAt = modbus::kHeaderSize, kValuesAt = kFunctionAt + 2;

std::span<const std::uint8_t> bytes_of(const std::string& unit) {
  return {reinterpret_cast<const std::uint8_t*>(unit.data()), unit.size()};
}

/// A reply with values shows that the device had the addresses.
struct AllAddresses final : modbus::AddressSpace {
  [[nodiscard]] bool has(Area, std::uint16_t, std::uint16_t, bool) const override { return true; }
};

/// Whether a reply answers a request: transaction, unit id and function are equal.
bool answers(const std::string& reply, const std::string& request) {
  return reply.compare(0, 2, request, 0, 2) == 0 &&
         reply.compare(kFunctionAt - 1, 2, request, kFunctionAt - 1, 2) == 0;
}

struct Range {
  Area area = Area::kHoldingRegister;
  std::uint16_t address = 0, quantity = 0;

  [[nodiscard]] bool bits() const { return area == Area::kCoil || area == Area::kDiscreteInput; }
};

std::optional<Range> read_by(const modbus::Request& request) {
  switch (request.function) {
    case Function::kReadCoils:
      return Range{Area::kCoil, request.address, request.quantity};
    case Function::kReadDiscreteInputs:
      return Range{Area::kDiscreteInput, request.address, request.quantity};
    case Function::kReadHoldingRegisters:
      return Range{Area::kHoldingRegister, request.address, request.quantity};
    case Function::kReadInputRegisters:
      return Range{Area::kInputRegister, request.address, request.quantity};
    case Function::kReadWriteRegisters:
      return Range{Area::kHoldingRegister, request.read_address, request.read_quantity};
    default:
      return std::nullopt;
  }
}

/// Words, or 0 and 1, of a reply's data.
std::vector<std::uint16_t> values_in(const std::string& reply, const Range& range) {
  const auto data = bytes_of(reply).subspan(kValuesAt);
  std::vector<std::uint16_t> values(range.quantity);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const unsigned value =
        range.bits() ? (data[i / 8] >> (i % 8)) & 1U : data[2 * i] * 256U + data[2 * i + 1];
    values[i] = static_cast<std::uint16_t>(value);
  }
  return values;
}

}  // namespace

void ModbusReplies::received(const std::string& unit, world::RunTime at) {
  if (unit.size() <= kFunctionAt) return;
  asked_.push_back({at, unit});
  if (asked_.size() > kMostUnanswered) asked_.pop_front();
}

std::optional<WireReply> ModbusReplies::sent(const std::string& unit, world::RunTime at) {
  const auto answered = [&](const Asked& asked) {
    // An exception has the highest bit of the function set.
    std::string reply = unit;
    reply[kFunctionAt] = static_cast<char>(reply[kFunctionAt] & 0x7F);
    return answers(reply, asked.unit);
  };
  if (unit.size() <= kValuesAt) return std::nullopt;
  const auto found = std::ranges::find_if(asked_, answered);
  if (found == asked_.end()) return std::nullopt;
  Asked asked = std::move(*found);
  asked_.erase(asked_.begin(), found + 1);
  // The first of two requests with one number may never have been answered.
  const bool other = std::ranges::any_of(
      asked_, [&](const Asked& later) { return answered(later) && later.unit != asked.unit; });
  const AllAddresses addresses;
  const auto validated = modbus::validate_request(bytes_of(asked.unit), {.addresses = &addresses});
  if (other || validated.verdict != modbus::Verdict::kRequest) return std::nullopt;
  const auto range = read_by(validated.request);
  if (!range || unit[kFunctionAt] != asked.unit[kFunctionAt]) return std::nullopt;
  const std::size_t size = range->bits() ? (range->quantity + 7U) / 8U : 2U * range->quantity;
  if (unit.size() != kValuesAt + size) return std::nullopt;
  const ReadRegisters read{range->area, range->address, values_in(unit, *range)};
  return WireReply{asked.at, at, [read, registers = registers_](const api::Snapshot& snapshot) {
                     return registers(read, snapshot);
                   }};
}

}  // namespace aprsim::server::journal
