#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "clients/wires/outcome.hpp"
#include "modbus/conveyor_registers.hpp"

struct _modbus;  // NOLINT(bugprone-reserved-identifier): the name that libmodbus gives it

namespace aprsim::client {

/// Connection to the conveyor's Modbus server as a master.
class ConveyorConnection {
 public:
  [[nodiscard]] static Outcome<ConveyorConnection> connect(const std::string& host,
                                                           std::uint16_t port);
  /// Writes one holding register (function code 6).
  [[nodiscard]] Outcome<void> write(std::uint16_t address, std::uint16_t value);
  /// Every documented register but the light curtain's single beams (function codes 1 to 4).
  [[nodiscard]] Outcome<modbus::RegisterImage> read();

 private:
  struct Close {
    void operator()(_modbus* context) const;
  };
  explicit ConveyorConnection(std::unique_ptr<_modbus, Close> context);

  std::unique_ptr<_modbus, Close> context_;
};

}  // namespace aprsim::client
