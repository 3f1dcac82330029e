#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "modbus/register_map.hpp"
#include "server/replay/deviation.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::server::journal {

/// Registers that a recorded Modbus reply gives: words, or 0 and 1, from an address on.
struct ReadRegisters {
  modbus::Area area = modbus::Area::kHoldingRegister;
  std::uint16_t address = 0;
  std::vector<std::uint16_t> values;
};

/// Their deviation from the cell at a moment. Thread: one at a time.
using RegisterDeviation = std::function<Deviation(const ReadRegisters&, const api::Snapshot&)>;

/// Compares the documented registers of the conveyor's PLC.
[[nodiscard]] RegisterDeviation conveyor_deviation(const modbus::ConveyorScaling& scaling);
/// Compares the registers of the scene's server `server` that a signal determines.
[[nodiscard]] RegisterDeviation map_deviation(const std::string& server);

}  // namespace aprsim::server::journal
