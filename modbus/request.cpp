#include "modbus/request.hpp"

#include <array>
#include <optional>

namespace aprsim::modbus {
namespace {

enum class Form : std::uint8_t { kRead, kWriteSingle, kWriteMultiple, kMaskWrite, kReadWrite };

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
    FunctionInfo{Function::kMaskWriteRegister, Form::kMaskWrite, false, 1},
    FunctionInfo{Function::kReadWriteRegisters, Form::kReadWrite, false, kMaxReadWriteRegisters},
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
  return Request{info.function, word_at(pdu, 1), 1, pdu.subspan(3, 2), 0, 0};
}

std::optional<Request> parse_read(const FunctionInfo& info, Bytes pdu) {
  if (pdu.size() != kHead) return std::nullopt;
  const std::uint16_t quantity = word_at(pdu, 3);
  if (quantity < 1 || quantity > info.max_quantity) return std::nullopt;
  return Request{info.function, word_at(pdu, 1), quantity, {}, 0, 0};
}

std::optional<Request> parse_write_multiple(const FunctionInfo& info, Bytes pdu) {
  if (pdu.size() < kHead + 1) return std::nullopt;
  const std::uint16_t quantity = word_at(pdu, 3);
  if (quantity < 1 || quantity > info.max_quantity) return std::nullopt;
  const std::size_t bytes = info.bits ? (quantity + 7U) / 8U : 2U * quantity;
  if (pdu[kHead] != bytes || pdu.size() != kHead + 1 + bytes) return std::nullopt;
  return Request{info.function, word_at(pdu, 1), quantity, pdu.subspan(kHead + 1), 0, 0};
}

std::optional<Request> parse_mask_write(const FunctionInfo& info, Bytes pdu) {
  if (pdu.size() != kHead + 2) return std::nullopt;
  return Request{info.function, word_at(pdu, 1), 1, pdu.subspan(3, 4), 0, 0};
}

std::optional<Request> parse_read_write(const FunctionInfo& info, Bytes pdu) {
  constexpr std::size_t kWriteHead = kHead + 4;  // up to the byte count
  if (pdu.size() < kWriteHead + 1) return std::nullopt;
  const std::uint16_t reads = word_at(pdu, 3), writes = word_at(pdu, kHead + 2);
  if (reads < 1 || reads > kMaxReadRegisters) return std::nullopt;
  if (writes < 1 || writes > info.max_quantity) return std::nullopt;
  const std::size_t bytes = std::size_t{2} * writes;
  if (pdu[kWriteHead] != bytes || pdu.size() != kWriteHead + 1 + bytes) return std::nullopt;
  return Request{info.function,   word_at(pdu, kHead),
                 writes,          pdu.subspan(kWriteHead + 1),
                 word_at(pdu, 1), reads};
}

std::optional<Request> parse_body(const FunctionInfo& info, Bytes pdu) {
  switch (info.form) {
    case Form::kRead:
      return parse_read(info, pdu);
    case Form::kWriteSingle:
      return parse_write_single(info, pdu);
    case Form::kWriteMultiple:
      return parse_write_multiple(info, pdu);
    case Form::kMaskWrite:
      return parse_mask_write(info, pdu);
    case Form::kReadWrite:
      return parse_read_write(info, pdu);
  }
  return std::nullopt;
}

/// Whether the device has all addresses of the request.
bool has_addresses(const Request& request, const AddressSpace* addresses) {
  const auto has = [addresses](Area area, std::uint16_t address, std::uint16_t count, bool write) {
    return addresses == nullptr ? is_mapped(address, count)
                                : addresses->has(area, address, count, write);
  };
  const bool reads_mapped =
      request.read_quantity == 0 ||
      has(Area::kHoldingRegister, request.read_address, request.read_quantity, false);
  const Area area = area_of(request.function);
  return reads_mapped && has(area, request.address, request.quantity, request.is_write());
}

}  // namespace

Area area_of(Function function) {
  switch (function) {
    case Function::kReadCoils:
    case Function::kWriteSingleCoil:
    case Function::kWriteMultipleCoils:
      return Area::kCoil;
    case Function::kReadDiscreteInputs:
      return Area::kDiscreteInput;
    case Function::kReadInputRegisters:
      return Area::kInputRegister;
    default:
      return Area::kHoldingRegister;
  }
}

Checked<Request> parse_request(Bytes pdu, const AddressSpace* addresses) {
  const FunctionInfo* info = find_function(pdu[0]);
  if (info == nullptr) return tl::unexpected(ExceptionCode::kIllegalFunction);
  const std::optional<Request> request = parse_body(*info, pdu);
  if (!request) return tl::unexpected(ExceptionCode::kIllegalDataValue);
  if (!has_addresses(*request, addresses)) {
    return tl::unexpected(ExceptionCode::kIllegalDataAddress);
  }
  return *request;
}

bool is_writing_function(std::uint8_t code) {
  const FunctionInfo* info = find_function(code);
  return info != nullptr && info->form != Form::kRead;
}

}  // namespace aprsim::modbus
