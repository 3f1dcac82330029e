#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include "modbus/register_map.hpp"

namespace aprsim::client::conform {

/// Addresses from one on.
struct AddressRun {
  std::uint16_t address = 0, count = 0;
};

/// Which addresses a Modbus server has.
class ModbusShape {
 public:
  void add(modbus::Area area, std::uint16_t address, bool writable);

  [[nodiscard]] bool empty() const { return readable_.empty(); }
  /// The longest run in an area; absent = the area has none.
  [[nodiscard]] std::optional<AddressRun> longest(modbus::Area area, bool writable) const;
  /// An address that the area lacks, or that cannot be written; absent = there is none.
  [[nodiscard]] std::optional<std::uint16_t> missing(modbus::Area area, bool writable) const;
  /// An address that can only be read; absent = there is none.
  [[nodiscard]] std::optional<std::uint16_t> only_read(modbus::Area area) const;

 private:
  using Addresses = std::set<std::pair<modbus::Area, std::uint16_t>>;
  [[nodiscard]] const Addresses& of(bool writable) const {
    return writable ? writable_ : readable_;
  }
  Addresses readable_, writable_;
};

}  // namespace aprsim::client::conform
