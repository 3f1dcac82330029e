#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "modbus/register_view.hpp"
#include "modbus/request.hpp"
#include "modbus/value_encoding.hpp"
#include "world/api/signals/bound_signal.hpp"

namespace aprsim::modbus_server {

/// A register whose signal has been found in the cell.
struct BoundRegister {
  modbus::Area area = modbus::Area::kHoldingRegister;
  std::uint16_t address = 0;
  bool writable = false;
  modbus::ValueFormat format;
  std::string signal_name;
  api::BoundSignal signal;
};

/// A map of a scene in one cell: which addresses there are, and which registers have them. Thread:
/// one at a time.
class BoundMap {
 public:
  /// Without registers: no address exists.
  BoundMap() = default;
  /// Registers whose signal the cell does not have are left out.
  BoundMap(const api::RegisterMap& map, const api::CellDescription& cell);

  /// As of modbus::AddressSpace.
  [[nodiscard]] bool has(modbus::Area area, std::uint16_t address, std::uint16_t count,
                         bool write) const;

  [[nodiscard]] std::span<const BoundRegister> registers() const { return registers_; }
  /// Those with an address in [address, address + count), by address.
  [[nodiscard]] std::vector<const BoundRegister*> touched(modbus::Area area, std::uint16_t address,
                                                          std::size_t count) const;
  /// The lowest address, and the number of addresses from there to the highest.
  [[nodiscard]] std::uint16_t first() const { return first_; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  /// Bits of an address, from first_ on.
  static constexpr std::uint8_t kReadable = 1, kWritable = 16;
  [[nodiscard]] static std::uint8_t mark_of(modbus::Area area, bool write);

  std::vector<BoundRegister> registers_;  // by area and address
  std::vector<std::uint8_t> marks_;       // of each address, in each area
  std::uint16_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace aprsim::modbus_server
