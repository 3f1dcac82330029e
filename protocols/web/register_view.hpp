#pragma once

#include "aprsim/v1/web.pb.h"
#include "modbus/conveyor_registers.hpp"

/// The PLC's documented registers as messages of aprsim.v1.
namespace aprsim::web {

/// Of registers that stand in a row, one for each beam of a light curtain, the first `beams`.
void write_message(const modbus::ConveyorScaling& scaling, int beams, v1::RegisterMap& message);
/// In the same order.
void write_message(const modbus::RegisterImage& image, int beams, v1::RegisterValues& message);

}  // namespace aprsim::web
