#include "modbus/request.hpp"

#include <array>
#include <optional>

namespace aprsim::modbus {
namespace {

enum class Form : std::uint8_t { kRead, kWriteSingle, kWriteMultiple };

struct FunctionInfo {
  Function function;
  Form form;
  bool bits;
  std::uint16_t max_quantity;
};

constexpr std::array kFunctions{
    FunctionInfo{Function::kReadCoils, Form::kRead, true, kMaxReadBits},
    FunctionInfo{Function::kReadDiscreteInputs, Form::kRead, true, kMaxReadBits},
    FunctionInfo{Function::kReadHoldingRegisters, Form::kRead, false, kMaxReadRegisters},
    FunctionInfo{Function::kReadInputRegisters, Form::kRead, false, kMaxReadRegisters},
    FunctionInfo{Function::kWriteSingleCoil, Form::kWriteSingle, true, 1},
    FunctionInfo{Function::kWriteSingleRegister, Form::kWriteSingle, false, 1},
    FunctionInfo{Function::kWriteMultipleCoils, Form::kWriteMultiple, true, kMaxWriteBits},
    FunctionInfo{Function::kWriteMultipleRegisters, Form::kWriteMultiple, false,
                 kMaxWriteRegisters},
};

const FunctionInfo* find_function(std::uint8_t code) {
  for (const FunctionInfo& info : kFunctions) {
    if (static_cast<std::uint8_t>(info.function) == code) return &info;
  }
  return nullptr;
}

using Bytes = std::span<const std::uint8_t>;

std::uint16_t word_at(Bytes bytes, std::size_t at) {
  return static_cast<std::uint16_t>((bytes[at] << 8) | bytes[at + 1]);
}

constexpr std::size_t kHead = 5;  // function, address, quantity or value

std::optional<Request> parse_write_single(const FunctionInfo& info, Bytes pdu) {
  if (pdu.size() != kHead) return std::nullopt;
  const std::uint16_t value = word_at(pdu, 3);
  if (info.bits && value != 0x0000 && value != 0xFF00) return std::nullopt;
  return Request{info.function, word_at(pdu, 1), 1, pdu.subspan(3, 2)};
}

std::optional<Request> parse_read(const FunctionInfo& info, Bytes pdu) {
  if (pdu.size() != kHead) return std::nullopt;
  const std::uint16_t quantity = word_at(pdu, 3);
  if (quantity < 1 || quantity > info.max_quantity) return std::nullopt;
  return Request{info.function, word_at(pdu, 1), quantity, {}};
}

std::optional<Request> parse_write_multiple(const FunctionInfo& info, Bytes pdu) {
  if (pdu.size() < kHead + 1) return std::nullopt;
  const std::uint16_t quantity = word_at(pdu, 3);
  if (quantity < 1 || quantity > info.max_quantity) return std::nullopt;
  const std::size_t bytes = info.bits ? (quantity + 7U) / 8U : 2U * quantity;
  if (pdu[kHead] != bytes || pdu.size() != kHead + 1 + bytes) return std::nullopt;
  return Request{info.function, word_at(pdu, 1), quantity, pdu.subspan(kHead + 1)};
}

std::optional<Request> parse_body(const FunctionInfo& info, Bytes pdu) {
  switch (info.form) {
    case Form::kRead:
      return parse_read(info, pdu);
    case Form::kWriteSingle:
      return parse_write_single(info, pdu);
    case Form::kWriteMultiple:
      return parse_write_multiple(info, pdu);
  }
  return std::nullopt;
}

}  // namespace

Checked<Request> parse_request(Bytes pdu) {
  const FunctionInfo* info = find_function(pdu[0]);
  if (info == nullptr) return tl::unexpected(ExceptionCode::kIllegalFunction);
  const std::optional<Request> request = parse_body(*info, pdu);
  if (!request) return tl::unexpected(ExceptionCode::kIllegalDataValue);
  if (!is_mapped(request->address, request->quantity)) {
    return tl::unexpected(ExceptionCode::kIllegalDataAddress);
  }
  return *request;
}

}  // namespace aprsim::modbus
