// Injected faults carried out on the parts of a cell.

#include "world/cell/fault_executor.hpp"

#include <gtest/gtest.h>

#include "tests/unit/world/cell/bare_cell.hpp"

namespace aprsim::test {
namespace {

using Eigen::Vector3d;
using faults::Kind;

constexpr const char* kGear = "part_large_gear_1";
constexpr const char* kOtherGear = "part_medium_gear_1";
constexpr const char* kTray = "large_gear_vessel_1";

class FaultExecutorTest : public testing::Test {
 protected:
  static world::FaultSpec spec(Kind kind, int body = -1) {
    world::FaultSpec fault;
    fault.kind = kind;
    fault.body = body;
    return fault;
  }
  static void set(world::FaultSpec& fault, std::string_view parameter, double value) {
    fault.values[faults::info(fault.kind).parameter(parameter).value()] = value;
  }
  /// Effects without any fault.
  [[nodiscard]] world::FaultEffects no_effects() const {
    return world::effects_of({}, SimTime{}, cell.settings.joint_names, cell.settings.light_curtain);
  }

  BareCell cell;
};

TEST_F(FaultExecutorTest, TripsARobot) {
  auto fault = spec(Kind::kProtectiveStop);
  fault.robot = 1;
  EXPECT_EQ(cell.executor().carry_out(fault), "");
  EXPECT_FALSE(cell.robots[0].stopped_by_protection());
  EXPECT_TRUE(cell.robots[1].stopped_by_protection());
}

TEST_F(FaultExecutorTest, NotesThatALostPartCannotBeChanged) {
  const int gear = cell.body(kGear);
  EXPECT_EQ(cell.executor().carry_out(spec(Kind::kPartMissing, gear)), "");
  EXPECT_TRUE(cell.physics->body(gear).lost_step);
  auto swap = spec(Kind::kPartSwapped, cell.body(kOtherGear));
  swap.other_body = gear;
  for (const auto& fault :
       {spec(Kind::kPartMissing, gear), spec(Kind::kPartMisplaced, gear),
        spec(Kind::kPartUpsideDown, gear), spec(Kind::kPartStray, gear), swap}) {
    EXPECT_EQ(cell.executor().carry_out(fault), "it is not in the cell any more");
  }
}

TEST_F(FaultExecutorTest, SwapsTwoParts) {
  const int a = cell.body(kGear), b = cell.body(kOtherGear);
  const Vector3d p_a = cell.X_WB(a).translation(), p_b = cell.X_WB(b).translation();
  auto fault = spec(Kind::kPartSwapped, a);
  fault.other_body = b;
  EXPECT_EQ(cell.executor().carry_out(fault), "");
  EXPECT_LT((cell.X_WB(a).translation() - p_b).head<2>().norm(), 1e-9);
  EXPECT_LT((cell.X_WB(b).translation() - p_a).head<2>().norm(), 1e-9);
}

TEST_F(FaultExecutorTest, TurnsAPartOver) {
  const int gear = cell.body(kGear);
  EXPECT_EQ(cell.executor().carry_out(spec(Kind::kPartUpsideDown, gear)), "");
  EXPECT_NEAR(cell.X_WB(gear)(2, 2), -1, 1e-9);
}

TEST_F(FaultExecutorTest, ShiftsATrayWithTheGearsOnIt) {
  const int tray = cell.body(kTray);
  const Eigen::Isometry3d X_WP = cell.X_WB(tray);
  std::vector<std::pair<int, Eigen::Isometry3d>> on_it;  // in the tray's frame
  std::vector<std::pair<int, Eigen::Isometry3d>> others;
  for (int i = 0; i < cell.physics->body_count(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    if (!cell.settings.bodies[index].is_gear()) continue;
    const bool stands =
        scene::stands_on(cell.X_WB(i), X_WP, cell.settings.bodies[static_cast<std::size_t>(tray)]);
    if (stands) {
      on_it.emplace_back(i, X_WP.inverse() * cell.X_WB(i));
    } else {
      others.emplace_back(i, cell.X_WB(i));
    }
  }
  ASSERT_FALSE(on_it.empty());
  ASSERT_FALSE(others.empty());
  auto fault = spec(Kind::kTrayShifted, tray);
  set(fault, "x", 0.01);
  set(fault, "yaw", 0.1);
  EXPECT_EQ(cell.executor().carry_out(fault), "");
  const Eigen::Isometry3d X_new = cell.X_WB(tray);
  EXPECT_NEAR(X_new.translation().x() - X_WP.translation().x(), 0.01, 1e-9);
  for (const auto& [gear, X_PG] : on_it) {
    EXPECT_LT((cell.X_WB(gear).translation() - X_new * X_PG.translation()).norm(), 1e-9);
  }
  for (const auto& [gear, X_WG] : others) {
    EXPECT_EQ(cell.X_WB(gear).translation(), X_WG.translation());
  }
}

TEST_F(FaultExecutorTest, SetsTheEffectsOfLastingFaultsAndTakesThemBack) {
  world::FaultEffects effects = no_effects();
  effects.belt.emergency_stop = true;
  effects.robots[0].gripper_setting = 1.0;
  effects.photo_eyes[0] = true;
  cell.executor().apply(effects);
  EXPECT_TRUE(cell.conveyor.readings().emergency_stop);
  EXPECT_EQ(cell.robots[0].gripper_setting(), 1.0);
  const auto read_eye = [&] {
    cell.photo_eyes.begin();
    cell.photo_eyes.finish();
    return cell.readings().beam_broken(0);
  };
  EXPECT_TRUE(read_eye());
  cell.executor().apply(no_effects());
  EXPECT_FALSE(cell.conveyor.readings().emergency_stop);
  EXPECT_FALSE(read_eye());
}

}  // namespace
}  // namespace aprsim::test
