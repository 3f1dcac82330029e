#include "world/physics/gripper/suction_cup.hpp"

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

constexpr double kCupStep = 1e-3;
constexpr LipSeal kSealed{.leak_m2 = 0, .covered = 1};

scene::VacuumCup cup() {
  return {.radius_m = 0.01,
          .max_vacuum_pa = 60e3,
          .free_flow_m3_s = 2e-4,
          .evacuation_s = 0.02,
          .lip_compliance_m = 5e-4,
          .roughness_m = 0};
}

TEST(SuctionCup, EvacuatesOverTimeAndThenHoldsWithItsFullForce) {
  SuctionCup own(cup());
  own.advance(true, kSealed, 3, 1, kCupStep);
  EXPECT_FALSE(own.is_steady());
  const double first = own.suction().force_n;
  for (int i = 0; i < 200; ++i) own.advance(true, kSealed, 3, 1, kCupStep);
  EXPECT_TRUE(own.is_steady());
  EXPECT_EQ(own.suction().body, 3);
  EXPECT_GT(own.suction().force_n, first);
  EXPECT_NEAR(own.suction().force_n, own.full_force_n(), 1e-3 * own.full_force_n());
}

TEST(SuctionCup, KeepsSomeSuctionForAWhileAfterTheEjector) {
  SuctionCup own(cup());
  EXPECT_FALSE(own.has_suction(false));
  EXPECT_TRUE(own.has_suction(true));
  for (int i = 0; i < 200; ++i) own.advance(true, kSealed, 3, 1, kCupStep);
  own.advance(false, kSealed, 3, 1, kCupStep);
  EXPECT_TRUE(own.has_suction(false));
  for (int i = 0; i < 400; ++i) own.advance(false, kSealed, 3, 1, kCupStep);
  EXPECT_FALSE(own.has_suction(false));
}

TEST(SuctionCup, HoldsNothingOnceTheAirIsIn) {
  SuctionCup own(cup());
  for (int i = 0; i < 200; ++i) own.advance(true, kSealed, 3, 1, kCupStep);
  own.vent();
  EXPECT_EQ(own.suction().body, -1);
  EXPECT_EQ(own.suction().force_n, 0);
  EXPECT_EQ(own.vacuum_pa(), 0);
  EXPECT_TRUE(own.is_steady());
}

}  // namespace
}  // namespace aprsim::physics
