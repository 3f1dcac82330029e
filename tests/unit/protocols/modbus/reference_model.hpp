#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "tests/unit/modbus/bytes.hpp"

namespace aprsim::modbus::testing {

/// A second opinion on the device, written from the protocol specification and the documented map
/// alone, one function code after the other and without sharing any code with the product.
/// Drive: default scaling; a value takes effect at once.
class ReferenceModel {
 public:
  /// The reply to one complete frame; nothing for one that is not Modbus.
  std::optional<Bytes> answer(const Bytes& frame);

 private:
  Bytes respond(const Bytes& body);
  Bytes read_bits(const Bytes& body, const std::map<int, bool>& area);
  Bytes read_words(const Bytes& body, const std::map<int, int>& area);
  Bytes write_coil(const Bytes& body);
  Bytes write_register(const Bytes& body);
  Bytes write_coils(const Bytes& body);
  Bytes write_registers(const Bytes& body);
  Bytes mask_write(const Bytes& body);
  Bytes read_write(const Bytes& body);
  static Bytes identify(const Bytes& body);
  void store_word(int address, int value);
  void store_coils(const std::map<int, bool>& values);
  [[nodiscard]] std::map<int, int> inputs() const;
  [[nodiscard]] std::map<int, bool> discrete() const;
  [[nodiscard]] std::map<int, bool> coils() const;

  std::map<int, int> holding_{{0x8001, 1}};
  std::map<int, bool> coils_;  // but for those that mirror registers
  bool faulted_ = false;       // by an emergency stop, the only cause here
};

}  // namespace aprsim::modbus::testing
