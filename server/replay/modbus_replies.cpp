#include "server/replay/modbus_replies.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "modbus/conveyor_registers.hpp"
#include "modbus/request_validator.hpp"
#include "protocols/conveyor/conveyor_device.hpp"

namespace aprsim::server::journal {
namespace {

using modbus::Area;
using modbus::Function;

constexpr std::size_t kFunctionAt = modbus::kHeaderSize, kValuesAt = kFunctionAt + 2;

std::span<const std::uint8_t> bytes_of(const std::string& unit) {
  return {reinterpret_cast<const std::uint8_t*>(unit.data()), unit.size()};
}

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

std::uint16_t value_in(const modbus::RegisterImage& image, Area area, std::uint16_t address) {
  const std::size_t at = address - modbus::kFirstAddress;
  switch (area) {
    case Area::kCoil:
      return image.coils[at];
    case Area::kDiscreteInput:
      return image.discrete[at];
    case Area::kInputRegister:
      return image.input[at];
    case Area::kHoldingRegister:
      break;
  }
  return image.holding[at];
}

/// The speed reads as it was written if the drive's setting results from it.
bool speed_as_written(std::uint16_t counts, const modbus::ConveyorReadings& readings,
                      const modbus::ConveyorScaling& scaling) {
  const double written = counts * scaling.m_s_per_count();
  return readings.speed_setting_m_s == written ||
         readings.speed_setting_m_s == std::min(written, readings.max_speed_m_s);
}

Deviation deviation_of(const std::string& reply, const Range& range,
                       const modbus::ConveyorReadings& readings,
                       const modbus::ConveyorScaling& scaling) {
  // Registers without a function in the cell keep their values: the difference of these two.
  modbus::RegisterImage zeros, ones;
  ones.coils.fill(1);
  ones.discrete.fill(1);
  ones.holding.fill(1);
  ones.input.fill(1);
  encode(readings, scaling, zeros);
  encode(readings, scaling, ones);
  const auto values = bytes_of(reply).subspan(kValuesAt);
  Deviation all;
  for (std::uint16_t i = 0; i < range.quantity; ++i) {
    const auto address = static_cast<std::uint16_t>(range.address + i);
    const modbus::RegisterInfo* info = modbus::find_register(range.area, address);
    const std::uint16_t here = value_in(zeros, range.area, address);
    if (info == nullptr || here != value_in(ones, range.area, address)) continue;
    const unsigned then = range.bits() ? (values[i / 8U] >> (i % 8U)) & 1U
                                       : values[2U * i] * 256U + values[2U * i + 1];
    const bool speed = range.area == Area::kHoldingRegister && address == modbus::kSpeedRegister;
    if (speed && speed_as_written(static_cast<std::uint16_t>(then), readings, scaling)) continue;
    all.number(fmt::format("{} ({:#06x})", info->name, address), then, here);
  }
  return all;
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
  const auto validated = modbus::validate_request(bytes_of(asked.unit));
  if (other || validated.verdict != modbus::Verdict::kRequest) return std::nullopt;
  const auto range = read_by(validated.request);
  if (!range || unit[kFunctionAt] != asked.unit[kFunctionAt]) return std::nullopt;
  const std::size_t size = range->bits() ? (range->quantity + 7U) / 8U : 2U * range->quantity;
  if (unit.size() != kValuesAt + size) return std::nullopt;
  return WireReply{asked.at, at,
                   [unit, range = *range, scaling = scaling_](const api::Snapshot& snapshot) {
                     return deviation_of(unit, range, conveyor::readings_of(snapshot), scaling);
                   }};
}

}  // namespace aprsim::server::journal
