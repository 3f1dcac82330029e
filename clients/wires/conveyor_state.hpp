#pragma once

#include "modbus/conveyor_registers.hpp"

namespace aprsim::client {

/// The conveyor as its registers report it, in SI units, without the light curtain's single beams.
struct ConveyorState {
  modbus::ConveyorReadings readings;
  modbus::DriveState drive = modbus::DriveState::kAbsent;  ///< a number may lie outside the enum
  double target_speed_m_s = 0;                             ///< forward positive
  bool ready = false;                                      ///< nothing keeps the belt from running
};

/// Decodes registers; inverse of modbus::encode within the registers' resolution and range. The
/// scaling is that of the installation.
[[nodiscard]] ConveyorState conveyor_state(const modbus::RegisterImage& image,
                                           const modbus::ConveyorScaling& scaling);

}  // namespace aprsim::client
