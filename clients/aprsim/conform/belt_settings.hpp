#pragma once

#include <cstdint>
#include <vector>

#include "clients/aprsim/conform/modbus_probe.hpp"
#include "modbus/register_map.hpp"

namespace aprsim::client::conform {

/// Saves the belt's commanded settings before checks that write, and restores them afterwards. The
/// belt stops meanwhile; a stop or fault left by a check is reset.
class BeltSettings {
 public:
  explicit BeltSettings(const Target& target)
      : probe(target), before_(probe.words(3, modbus::kRunRegister, 3)) {
    make_ready();
  }
  ~BeltSettings() {
    try {
      make_ready();
      probe.write(modbus::kDirectionRegister, before_[1]);
      probe.write(modbus::kSpeedRegister, before_[2]);
      if (before_[0] != 0) probe.write(modbus::kRunRegister, before_[0]);
    } catch (...) {
      // The check has failed already, or everything is given up.
    }
  }
  BeltSettings(const BeltSettings&) = delete;
  BeltSettings& operator=(const BeltSettings&) = delete;

  ModbusProbe probe;

 private:
  void make_ready() {
    using modbus::conformance::pdu;
    probe.write(modbus::kRunRegister, 0);
    (void)probe.ask(pdu(5, {modbus::kEmergencyStopCoil, 0x0000}));
    (void)probe.ask(pdu(5, {modbus::kFaultResetCoil, 0xFF00}));
  }

  std::vector<std::uint16_t> before_;
};

}  // namespace aprsim::client::conform
