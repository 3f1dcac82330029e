#pragma once

#include <array>
#include <cstdint>

#include "aprsim/v1/web.pb.h"
#include "modbus/conveyor_registers.hpp"
#include "world/base/result.hpp"

/// The PLC's documented registers as messages of aprsim.v1.
namespace aprsim::web {

/// Descriptions of the registers; of those for the beams of a light curtain, the first `beams`.
void write_message(const modbus::ConveyorScaling& scaling, int beams, v1::RegisterMap& message);
/// Values in the same order.
void write_message(const modbus::RegisterImage& image, int beams, v1::RegisterValues& message);

/// A write of one register or coil, with the bytes that the device's request refers to.
struct RegisterWrite {
  modbus::Function function = modbus::Function::kWriteSingleRegister;
  std::uint16_t address = 0;
  std::array<std::uint8_t, 2> data{};

  [[nodiscard]] modbus::Request request() const;
};

/// Errors: kInvalidArgument naming "area", "address" or "value" with its limits.
[[nodiscard]] Result<RegisterWrite> to_register_write(const v1::WriteRegister& message);

}  // namespace aprsim::web
