#include "world/physics/gripper/finger_drive.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

scene::Gripper gripper(scene::GripperLaw law) {
  scene::Gripper g;
  g.law = law;
  g.force_n = 60;
  g.finger_speed_m_s = 0.1;
  g.coupling_n_m = 2e4;
  return g;
}

TEST(GripperLaw, CouplingIsEquationsOneAndTwo) {
  const std::array<FingerMotion, 2> fingers = {FingerMotion{1e-3, 0}, FingerMotion{2e-3, 0}};
  std::array<double, 2> force{};
  coupling_forces(fingers, 2e4, 0, force);
  EXPECT_DOUBLE_EQ(force[0], 2e4 * 1e-3);   // kp (p2 - p1)
  EXPECT_DOUBLE_EQ(force[1], -2e4 * 1e-3);  // kp (p1 - p2)
}

TEST(GripperLaw, CouplingOfThreeFingersSumsOverTheOthers) {
  const std::array<FingerMotion, 3> fingers = {FingerMotion{0, 0}, FingerMotion{1e-3, 0},
                                               FingerMotion{3e-3, 0}};
  std::array<double, 3> force{};
  coupling_forces(fingers, 1e4, 0, force);
  EXPECT_DOUBLE_EQ(force[0], 40);
  EXPECT_DOUBLE_EQ(force[1], 10);
  EXPECT_DOUBLE_EQ(force[2], -50);
  EXPECT_NEAR(force[0] + force[1] + force[2], 0, 1e-12);
}

// Any laws, any number of joints: here a cubic relative-error law and a single-joint spring.
TEST(GripperLaw, EquationThreeTakesAnyLaws) {
  const std::array<FingerMotion, 4> joints = {FingerMotion{0, 0}, FingerMotion{1, 0},
                                              FingerMotion{3, 0}, FingerMotion{3, 0}};
  std::array<double, 4> force{};
  mimic_joint_forces(
      joints, [](const FingerMotion& joint) { return 5 - joint.travel_m; },
      [](const FingerMotion& other, const FingerMotion& own) {
        const double error = other.travel_m - own.travel_m;
        return error * error * error;
      },
      force);
  EXPECT_DOUBLE_EQ(force[0], 5 + 1 + 27 + 27);
  EXPECT_DOUBLE_EQ(force[1], 4 - 1 + 8 + 8);
  EXPECT_DOUBLE_EQ(force[2], 2 - 27 - 8);
  EXPECT_DOUBLE_EQ(force[3], force[2]);
}

TEST(GripperLaw, PistonsCloseAndOpenAtTheSetSpeedAndCushionAtTheEnd) {
  LawState state;
  const auto g = gripper(scene::GripperLaw::kConstant);
  const std::array<FingerMotion, 2> mid = {FingerMotion{5e-3, 0}, FingerMotion{9.9e-3, 0}};
  const auto closing = finger_drives(g, true, mid, 0.01, 1e-3, state);
  EXPECT_DOUBLE_EQ(closing[0].speed_m_s, 0.1);
  EXPECT_LT(closing[1].speed_m_s, 0.03);
  EXPECT_GT(closing[1].speed_m_s, 0);
  EXPECT_DOUBLE_EQ(closing[0].piston_n, 60);
  EXPECT_DOUBLE_EQ(closing[0].extra_n, 0);
  const auto opening = finger_drives(g, false, mid, 0.01, 1e-3, state);
  EXPECT_DOUBLE_EQ(opening[0].speed_m_s, -0.1);
}

TEST(GripperLaw, MimicDrivesTheSecondFingerByItsErrorOnly) {
  LawState state;
  const auto g = gripper(scene::GripperLaw::kMimicPid);
  const std::array<FingerMotion, 2> level = {FingerMotion{5e-3, 0}, FingerMotion{5e-3, 0}};
  auto drives = finger_drives(g, true, level, 0.01, 1e-3, state);
  EXPECT_DOUBLE_EQ(drives[1].piston_n, 0);
  EXPECT_DOUBLE_EQ(drives[1].extra_n, 0);  // zero force at zero error: the paper's complaint
  const std::array<FingerMotion, 2> behind = {FingerMotion{5e-3, 0}, FingerMotion{4e-3, 0}};
  drives = finger_drives(g, true, behind, 0.01, 1e-3, state);
  const double first = drives[1].extra_n;
  EXPECT_NEAR(first, 20, 0.5);
  drives = finger_drives(g, true, behind, 0.01, 1e-3, state);
  EXPECT_GT(drives[1].extra_n, first);  // the integral grows
}

TEST(MimicPid, SumsProportionalIntegralAndDerivative) {
  const scene::MimicPid gains{.p_n_m = 1000, .i_n_ms = 5000, .d_ns_m = 7};
  MimicState state;
  EXPECT_NEAR(mimic_pid_force(gains, 1e9, 0.01, 0.5, 0.1, state), 10 + 5 + 3.5, 1e-12);
  EXPECT_NEAR(mimic_pid_force(gains, 1e9, 0.01, 0.5, 0.1, state), 10 + 10 + 3.5, 1e-12);
  EXPECT_NEAR(mimic_pid_force(gains, 1e9, 0, 0, 0.1, state), 10, 1e-12);  // the integral stays
}

// A second at the limit with a large error, then a small error the other way: without anti-windup
// the stored integral would hold the force at the limit for as long again.
TEST(MimicPid, DoesNotWindUpAtItsLimit) {
  const scene::MimicPid gains{.p_n_m = 1000, .i_n_ms = 5000, .d_ns_m = 0};
  MimicState state;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_LE(mimic_pid_force(gains, 60, 0.1, 0, 1e-3, state), 60);
  }
  EXPECT_EQ(state.integral_n, 0);  // 100 N proportional alone are over the limit
  EXPECT_NEAR(mimic_pid_force(gains, 60, -0.01, 0, 1e-3, state), -10.05, 1e-9);
}

TEST(MimicPid, BoundsItsIntegralByTheForceLimit) {
  const scene::MimicPid gains{.p_n_m = 0, .i_n_ms = 1e6, .d_ns_m = 0};
  MimicState state;
  for (int i = 0; i < 50; ++i) (void)mimic_pid_force(gains, 60, 1e-2, 0, 1e-3, state);
  EXPECT_LE(state.integral_n, 60);
  EXPECT_GT(state.integral_n, 49);
}

TEST(Pneumatics, TheForceFollowsTheChambersFilling) {
  auto g = gripper(scene::GripperLaw::kConstant);
  g.fill_time_s = 0.01;
  LawState state;
  const std::array<FingerMotion, 2> mid = {FingerMotion{5e-3, 0}, FingerMotion{5e-3, 0}};
  std::array<FingerDrive, 2> drives;
  for (int i = 0; i < 20; ++i) drives = finger_drives(g, true, mid, 0.01, 1e-3, state);
  // After two fill times: 1 - e^-2 in one chamber, e^-2 in the other.
  EXPECT_NEAR(drives[0].piston_n, 60 * (1 - 2 * std::exp(-2.0)), 1e-9);
  EXPECT_FALSE(air_is_steady(g, true, state.air));
  for (int i = 0; i < 40; ++i) drives = finger_drives(g, true, mid, 0.01, 1e-3, state);
  EXPECT_NEAR(drives[0].piston_n, 60, 0.4);
  EXPECT_TRUE(air_is_steady(g, true, state.air));
}

TEST(Pneumatics, UntilTheValveHasSwitchedTheFingersStayWhereTheyAre) {
  auto g = gripper(scene::GripperLaw::kConstant);
  g.fill_time_s = 0.05;
  LawState state;
  const std::array<FingerMotion, 2> open = {FingerMotion{0, 0}, FingerMotion{0, 0}};
  int steps = 0;
  while (finger_drives(g, true, open, 0.01, 1e-3, state)[0].speed_m_s <= 0) ++steps;
  EXPECT_NEAR(steps, 50 * std::log(2.0), 1);  // both chambers at half the supply
}

TEST(Pneumatics, ALeakTakesItsShareOfTheForce) {
  auto g = gripper(scene::GripperLaw::kConstant);
  g.fill_time_s = 0.01;
  g.leak_per_s = 25;
  LawState state;
  const std::array<FingerMotion, 2> mid = {FingerMotion{5e-3, 0}, FingerMotion{5e-3, 0}};
  std::array<FingerDrive, 2> drives;
  for (int i = 0; i < 200; ++i) drives = finger_drives(g, true, mid, 0.01, 1e-3, state);
  EXPECT_NEAR(drives[0].piston_n, 60 / 1.25, 1e-6);
}

TEST(Pneumatics, FrictionHoldsAgainstABackwardPushAndBrakesAnIdlePiston) {
  auto g = gripper(scene::GripperLaw::kConstant);
  g.friction_n = 5;
  LawState state;
  const std::array<FingerMotion, 2> fingers = {FingerMotion{5e-3, 0}, FingerMotion{5e-3, -0.01}};
  const auto drives = finger_drives(g, true, fingers, 0.01, 1e-3, state);
  EXPECT_DOUBLE_EQ(drives[0].piston_n, 60);
  EXPECT_DOUBLE_EQ(drives[1].piston_n, 70);  // 65 N of air and 5 N of friction
  g.fill_time_s = 0.01;
  state.air = {0.5, 0.5};
  const auto vented = finger_drives(g, true, fingers, 0.01, 1e-9, state);
  EXPECT_DOUBLE_EQ(vented[0].speed_m_s, 0);
  EXPECT_DOUBLE_EQ(vented[0].piston_n, 5);
}

TEST(GripperLaw, AServoTakesBothFingersToTheTargetAtFingerSpeed) {
  const auto g = gripper(scene::GripperLaw::kLinkage);
  const auto drives = servo_drives(g, 5e-3, {FingerMotion{0, 0}, FingerMotion{5.5e-3, 0}});
  EXPECT_DOUBLE_EQ(drives[0].speed_m_s, 0.1);
  EXPECT_LT(drives[1].speed_m_s, 0);
  EXPECT_GT(drives[1].speed_m_s, -0.1);
  EXPECT_DOUBLE_EQ(drives[0].piston_n, 60);
  EXPECT_DOUBLE_EQ(servo_drives(g, 5e-3, {FingerMotion{5e-3, 0}, {}})[0].speed_m_s, 0);
}

}  // namespace
}  // namespace aprsim::physics
