#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <tl/expected.hpp>

#include "modbus/register_map.hpp"

/// One Modbus request, parsed and checked against the limits of protocol and device.
/// Source: MODBUS Application Protocol Specification V1.1b3, sections 6 and 7.
namespace aprsim::modbus {

enum class ExceptionCode : std::uint8_t {
  kIllegalFunction = 1,      ///< not a function of this device
  kIllegalDataAddress = 2,   ///< part of the range is outside the device's addresses
  kIllegalDataValue = 3,     ///< quantity, byte count, length or value
  kServerDeviceFailure = 4,  ///< the request is valid, but the device could not execute it
  kServerDeviceBusy = 6,     ///< not accepted; the same request may succeed later
  kNoSuchUnit = 11,          ///< gateway target device failed to respond: another unit's id
};

template <typename T>
using Checked = tl::expected<T, ExceptionCode>;

enum class Function : std::uint8_t {
  kReadCoils = 1,
  kReadDiscreteInputs = 2,
  kReadHoldingRegisters = 3,
  kReadInputRegisters = 4,
  kWriteSingleCoil = 5,
  kWriteSingleRegister = 6,
  kWriteMultipleCoils = 15,
  kWriteMultipleRegisters = 16,
  kMaskWriteRegister = 22,
  kReadWriteRegisters = 23,
};

// Largest quantities of one request (specification, sections 6.1 to 6.17).
inline constexpr std::uint16_t kMaxReadBits = 2000;
inline constexpr std::uint16_t kMaxReadRegisters = 125;
inline constexpr std::uint16_t kMaxWriteBits = 1968;
inline constexpr std::uint16_t kMaxWriteRegisters = 123;
inline constexpr std::uint16_t kMaxReadWriteRegisters = 121;  ///< written by FC 23

/// A valid request. Refers to the bytes that it was parsed from.
struct Request {
  Function function = Function::kReadCoils;
  std::uint16_t address = 0;           ///< first address read, or written by a write
  std::uint16_t quantity = 0;          ///< 1 for the single writes
  std::span<const std::uint8_t> data;  ///< values of a write, as on the wire; else empty
  std::uint16_t read_address = 0;      ///< FC 23: first address read after the write
  std::uint16_t read_quantity = 0;     ///< FC 23

  [[nodiscard]] bool is_write() const { return !data.empty(); }
  [[nodiscard]] bool is_coil_write() const {
    return function == Function::kWriteSingleCoil || function == Function::kWriteMultipleCoils;
  }
  /// Value i of a register write; i < quantity. FC 22: 0 is the AND mask, 1 the OR mask.
  [[nodiscard]] std::uint16_t word(std::uint16_t i) const {
    const std::size_t at = std::size_t{2} * i;
    return static_cast<std::uint16_t>((data[at] << 8) | data[at + 1]);
  }
  /// Value i of a coil write; i < quantity.
  [[nodiscard]] bool bit(std::uint16_t i) const {
    if (function == Function::kWriteSingleCoil) return data[0] == 0xFF;
    return ((data[i / 8U] >> (i % 8U)) & 1) != 0;
  }
};

/// The addresses of a device.
class AddressSpace {
 public:
  AddressSpace() = default;
  AddressSpace(const AddressSpace&) = delete;
  AddressSpace& operator=(const AddressSpace&) = delete;
  virtual ~AddressSpace() = default;

  /// Whether all of [address, address + count) of an area can be read, or written.
  [[nodiscard]] virtual bool has(Area area, std::uint16_t address, std::uint16_t count,
                                 bool write) const = 0;
};

/// The area that a function reads or writes.
[[nodiscard]] Area area_of(Function function);

/// Parses a PDU (function code and what follows; never empty) and checks, in the order of the
/// specification's state diagrams: function (exception 1), quantity, byte count and length (3),
/// address range (2). The device checks the values of its registers. `addresses`: null = those of
/// the conveyor's PLC.
[[nodiscard]] Checked<Request> parse_request(std::span<const std::uint8_t> pdu,
                                             const AddressSpace* addresses = nullptr);

/// Whether a function code is one of those above that write.
[[nodiscard]] bool is_writing_function(std::uint8_t code);

}  // namespace aprsim::modbus
