#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/text/paint.hpp"
#include "modbus/conveyor_registers.hpp"

namespace aprsim::client {

/// What the conveyor's registers say, in SI units, but the light curtain's single beams. Inverse of
/// modbus::encode as far as the registers' resolution and range go.
struct ConveyorState {
  modbus::ConveyorReadings readings;
  modbus::DriveState drive = modbus::DriveState::kAbsent;
  double target_speed_m_s = 0;
  bool ready = false;
};

[[nodiscard]] ConveyorState conveyor_state(const modbus::RegisterImage& image,
                                           const modbus::ConveyorScaling& scaling);

/// A few lines.
[[nodiscard]] std::string conveyor_text(const ConveyorState& state, const Paint& paint);

[[nodiscard]] nlohmann::ordered_json conveyor_json(const ConveyorState& state);

/// What keeps the belt from running; empty = nothing.
[[nodiscard]] std::string conveyor_problem(const ConveyorState& state);

}  // namespace aprsim::client
