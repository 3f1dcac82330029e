#include "clients/aprsim/text/conveyor_text.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

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

TEST(ConveyorText, ABeltThatRunsHasNoProblem) {
  EXPECT_EQ(conveyor_problem(through_registers(running(), {})), "");
}

TEST(ConveyorText, AFaultIsSaid) {
  auto r = running();
  r.fault = modbus::FaultCode::kEmergencyStop;
  r.emergency_stop = true;
  const auto state = through_registers(r, {});
  EXPECT_FALSE(state.ready);
  EXPECT_NE(conveyor_problem(state).find("emergency stop"), std::string::npos);
  const std::string text = conveyor_text(state, Paint());
  EXPECT_NE(text.find("fault    emergency stop, emergency stop engaged"), std::string::npos)
      << text;
  EXPECT_EQ(conveyor_json(state).at("fault"), "emergency stop");
  EXPECT_EQ(conveyor_json(state).at("emergency_stop"), true);
}

TEST(ConveyorText, ACellWithoutABelt) {
  const auto state = through_registers({}, {});
  EXPECT_EQ(conveyor_problem(state), "the cell has no conveyor");
  EXPECT_TRUE(conveyor_json(state).at("light_curtain").is_null());
}

TEST(ConveyorText, NumbersThatNobodyDefinedAreShown) {
  modbus::RegisterImage image;
  image.input[modbus::kDriveStateRegister - modbus::kFirstAddress] = 77;
  image.input[modbus::kFaultCodeRegister - modbus::kFirstAddress] = 99;
  const auto state = conveyor_state(image, {});
  EXPECT_EQ(conveyor_json(state).at("drive"), "unknown");
  EXPECT_EQ(conveyor_json(state).at("fault"), "unknown");
  EXPECT_NE(conveyor_problem(state), "");
}

}  // namespace
}  // namespace aprsim::client
