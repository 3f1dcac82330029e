#include "clients/aprsim/text/conveyor_text.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/conveyor_readings.hpp"

namespace aprsim::client {
namespace {

using test::running_belt;
using test::through_registers;

TEST(ConveyorText, ABeltThatRunsHasNoProblem) {
  EXPECT_EQ(conveyor_problem(through_registers(running_belt(), {})), "");
}

TEST(ConveyorText, AFaultIsSaid) {
  auto r = running_belt();
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
