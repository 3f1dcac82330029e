#include "clients/wires/conveyor_state.hpp"

#include <gtest/gtest.h>

namespace aprsim::client {
namespace {

modbus::ConveyorReadings running() {
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

ConveyorState through_registers(const modbus::ConveyorReadings& readings,
                                const modbus::ConveyorScaling& scaling) {
  modbus::RegisterImage image;
  modbus::encode(readings, scaling, image);
  return conveyor_state(image, scaling);
}

TEST(ConveyorState, IsWhatTheRegistersWereMadeOf) {
  for (const bool one_is_forward : {true, false}) {
    const auto r = running();
    const auto state =
        through_registers(r, {.full_scale_m_s = 0.5, .one_is_forward = one_is_forward});
    const auto& back = state.readings;
    const double count = 0.5 / 32768;
    EXPECT_TRUE(back.present);
    EXPECT_TRUE(back.run);
    EXPECT_FALSE(back.forward);
    EXPECT_NEAR(back.speed_setting_m_s, r.speed_setting_m_s, count);
    EXPECT_NEAR(back.speed_m_s, r.speed_m_s, count);
    EXPECT_NEAR(state.target_speed_m_s, -0.15, count);
    EXPECT_NEAR(back.travel_m, r.travel_m, 1e-5);
    EXPECT_NEAR(back.max_speed_m_s, r.max_speed_m_s, count);
    EXPECT_EQ(back.time_ms, r.time_ms);
    EXPECT_NEAR(back.motor_current_a, r.motor_current_a, 1e-3);
    EXPECT_NEAR(back.load_kg, r.load_kg, 1e-2);
    EXPECT_FALSE(back.photo_eyes[0].broken);
    EXPECT_TRUE(back.photo_eyes[1].broken);
    EXPECT_EQ(back.photo_eyes[1].count, 7U);
    EXPECT_EQ(back.light_curtain.beams, 38);
    EXPECT_NEAR(back.light_curtain.range_m, 2.4, 1e-3);
    EXPECT_TRUE(back.light_curtain.broken);
    EXPECT_EQ(state.drive, modbus::drive_state(r));
    EXPECT_TRUE(state.ready);
  }
}

TEST(ConveyorState, AFaultIsReported) {
  auto r = running();
  r.fault = modbus::FaultCode::kEmergencyStop;
  r.emergency_stop = true;
  const auto state = through_registers(r, {});
  EXPECT_FALSE(state.ready);
  EXPECT_EQ(state.readings.fault, modbus::FaultCode::kEmergencyStop);
  EXPECT_TRUE(state.readings.emergency_stop);
}

TEST(ConveyorState, ACellWithoutABelt) {
  const auto state = through_registers({}, {});
  EXPECT_EQ(state.drive, modbus::DriveState::kAbsent);
  EXPECT_FALSE(state.readings.present);
}

}  // namespace
}  // namespace aprsim::client
