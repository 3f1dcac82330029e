#include "clients/wires/conveyor_state.hpp"

#include <gtest/gtest.h>

#include "tests/support/conveyor_readings.hpp"

namespace aprsim::client {
namespace {

using test::running_belt;
using test::through_registers;

TEST(ConveyorState, InvertsTheEncoding) {
  for (const bool one_is_forward : {true, false}) {
    const auto r = running_belt();
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
  auto r = running_belt();
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
