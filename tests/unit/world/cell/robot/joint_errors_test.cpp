#include "world/cell/robot/joint_errors.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

constexpr double kStep_s = 1e-3;
constexpr double kStep_rad = 0.2e-3;  ///< by which an error of an encoder changes in a step

class Joints : public testing::Test {
 protected:
  void step(double q0) {
    q(0) = q0;
    errors.step(q, faults, kStep_s);
  }
  double link(double q0) {
    q(0) = q0;
    return errors.links_at(q)(0);
  }

  robot::JointVector q = robot::JointVector::Zero(6);
  RobotFaults faults;
  JointErrors errors;
};

TEST_F(Joints, WithoutFaultsThereAreNone) {
  errors.begin(faults);
  step(0.1);
  EXPECT_FALSE(errors.any());
  EXPECT_EQ(link(0.1), 0.1);
}

TEST_F(Joints, AnEncodersErrorComesAndGoesAtItsSpeed) {
  faults.encoder_bias_rad[0] = 2.5 * kStep_rad;
  errors.begin(faults);
  EXPECT_TRUE(errors.any());
  step(0);
  EXPECT_NEAR(link(0), -kStep_rad, 1e-15);
  step(0);
  step(0);
  EXPECT_NEAR(link(0), -2.5 * kStep_rad, 1e-15);
  EXPECT_EQ(errors.links_at(q)(1), 0);
  faults.encoder_bias_rad[0] = 0;
  errors.begin(faults);
  for (int i = 0; i < 3; ++i) step(0);
  EXPECT_FALSE(errors.any());
  EXPECT_EQ(link(0), 0);
}

TEST_F(Joints, ALinkFollowsItsEncoderAtTheEndsOfThePlay) {
  const double half = 10 * kStep_rad;
  faults.backlash_rad[0] = 2 * half;
  errors.begin(faults);
  for (int i = 0; i < 20; ++i) step(0);
  // Forwards: the link rests until the play is used up, then it lags by half of it.
  step(0.5 * half);
  EXPECT_NEAR(link(0.5 * half), 0, 1e-12);
  step(3 * half);
  EXPECT_NEAR(link(3 * half), 2 * half, 1e-12);
  // Backwards through the whole play.
  step(1.5 * half);
  EXPECT_NEAR(link(1.5 * half), 2 * half, 1e-12);
  step(0);
  EXPECT_NEAR(link(0), half, 1e-12);
}

}  // namespace
}  // namespace aprsim::world
