#include "protocols/simple_message/controller_state.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace aprsim::simple_message {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

TEST(ControllerState, TheFanucCountsItsThirdJointAgainstTheHorizontal) {
  const std::vector<double> joints{0.1, 0.5, 1.25, 0.2, 0.3, 0.4};
  const Joints wire = to_wire(ControllerKind::kFanucKarel, joints);
  EXPECT_FLOAT_EQ(wire[2], 0.75F);
  EXPECT_FLOAT_EQ(wire[1], 0.5F);
  EXPECT_EQ(wire[6], 0);
  const auto back = from_wire(ControllerKind::kFanucKarel, wire, 6);
  ASSERT_EQ(back.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(back[i], joints[i], 1e-6) << i;
}

TEST(ControllerState, TheMotomansWireHasTheOrderOfItsModel) {
  const std::vector<double> joints{1, 2, 3, 4, 5, 6, 7};
  const Joints wire = to_wire(ControllerKind::kMotomanFs100, joints);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_FLOAT_EQ(wire[i], static_cast<float>(joints[i]));
  EXPECT_EQ(wire[7], 0);
}

TEST(ControllerState, PulsesOfADegree) {
  const std::vector<double> degree(7, kDegree * 1.0000001);
  EXPECT_EQ(pulses_of(degree),
            (std::vector<std::int64_t>{1024, 1024, 1024, 1024, 1149, 1149, 580}));
}

TEST(ControllerState, WildNumbersAreFarFromEverything) {
  std::vector<double> wild(7, 0);
  wild[3] = 1e300;
  EXPECT_FALSE(within_pulses(wild, std::vector<double>(7, 0), 30));
  wild[3] = std::nan("");
  EXPECT_FALSE(within_pulses(wild, std::vector<double>(7, 0), 30));
}

}  // namespace
}  // namespace aprsim::simple_message
