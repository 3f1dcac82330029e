#pragma once

#include "clients/wires/conveyor_state.hpp"

namespace aprsim::test {

/// Readings of a belt that runs in reverse at half its greatest speed, with a broken photo eye and
/// a broken light curtain.
inline modbus::ConveyorReadings running_belt() {
  modbus::ConveyorReadings r;
  r.present = true;
  r.run = true;
  r.forward = false;
  r.speed_setting_m_s = 0.15;
  r.speed_m_s = -0.15;
  r.travel_m = -1.23456;
  r.max_speed_m_s = 0.3;
  r.time_ms = 70'123;
  r.motor_current_a = 0.815;
  r.load_kg = 4.25;
  r.photo_eyes[1] = {true, 7};
  r.light_curtain.beams = 38;
  r.light_curtain.range_m = 2.4;
  r.light_curtain.broken = true;
  return r;
}

/// The state that a client reads from the registers of these readings.
inline client::ConveyorState through_registers(const modbus::ConveyorReadings& readings,
                                               const modbus::ConveyorScaling& scaling) {
  modbus::RegisterImage image;
  modbus::encode(readings, scaling, image);
  return client::conveyor_state(image, scaling);
}

}  // namespace aprsim::test
