#include "world/physics/gripper_law.hpp"

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

TEST(GripperLaw, PistonsCloseAndOpenAtTheSetSpeedAndCushionAtTheEnd) {
  MimicState mimic;
  const auto g = gripper(scene::GripperLaw::kConstant);
  const std::array<FingerMotion, 2> mid = {FingerMotion{5e-3, 0}, FingerMotion{9.9e-3, 0}};
  const auto closing = finger_drives(g, true, mid, 0.01, 1e-3, mimic);
  EXPECT_DOUBLE_EQ(closing[0].speed_m_s, 0.1);
  EXPECT_LT(closing[1].speed_m_s, 0.03);
  EXPECT_GT(closing[1].speed_m_s, 0);
  EXPECT_DOUBLE_EQ(closing[0].piston_n, 60);
  EXPECT_DOUBLE_EQ(closing[0].extra_n, 0);
  const auto opening = finger_drives(g, false, mid, 0.01, 1e-3, mimic);
  EXPECT_DOUBLE_EQ(opening[0].speed_m_s, -0.1);
}

TEST(GripperLaw, MimicDrivesTheSecondFingerByItsErrorOnly) {
  MimicState mimic;
  const auto g = gripper(scene::GripperLaw::kMimicPid);
  const std::array<FingerMotion, 2> level = {FingerMotion{5e-3, 0}, FingerMotion{5e-3, 0}};
  auto drives = finger_drives(g, true, level, 0.01, 1e-3, mimic);
  EXPECT_DOUBLE_EQ(drives[1].piston_n, 0);
  EXPECT_DOUBLE_EQ(drives[1].extra_n, 0);  // zero force at zero error: the paper's complaint
  const std::array<FingerMotion, 2> behind = {FingerMotion{5e-3, 0}, FingerMotion{4e-3, 0}};
  drives = finger_drives(g, true, behind, 0.01, 1e-3, mimic);
  const double first = drives[1].extra_n;
  EXPECT_NEAR(first, 20, 0.5);
  drives = finger_drives(g, true, behind, 0.01, 1e-3, mimic);
  EXPECT_GT(drives[1].extra_n, first);  // the integral grows
}

}  // namespace
}  // namespace aprsim::physics
