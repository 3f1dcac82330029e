// The joint reference by itself, without commands: planned motions, stops, retreat, drives.

#include "world/robot/controller/motion_generator.hpp"

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

class Generator : public testing::Test {
 protected:
  /// Plans a move of joint 0 and begins it.
  void begin(double target) {
    const PlannedMove move = api::MoveJoints{{{.joint = 0, .position_rad = target}}};
    PlanJob job(arm.planner,
                motion.request_plan(arm, {move, arm.X_FT, ToolLimitSettings(tool_maximum(setup))}));
    ASSERT_TRUE(job.get().outcome);
    ASSERT_TRUE(motion.is_as_expected(arm, job.get()));
    motion.begin(arm, move, job.get());
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) motion.step(arm, {}, false);
  }
  void rest() {
    for (int i = 0; i < 20000 && !motion.at_rest(); ++i) steps(1);
    ASSERT_TRUE(motion.at_rest());
  }
  double q0() const { return motion.reference()(0); }

  ControllerSetup setup = checked(rig_setup("fanuc"));
  EquippedArm arm = equipped_arms(setup).front();
  MotionGenerator motion{setup.q_home};
};

TEST_F(Generator, RunsAPlannedMotionToItsTarget) {
  EXPECT_TRUE(motion.at_rest());
  begin(0.3);
  EXPECT_FALSE(motion.at_rest());
  EXPECT_EQ(motion.end()(0), 0.3);
  rest();
  EXPECT_EQ(q0(), 0.3);
  const JointVector here = motion.reference();
  steps(10);
  EXPECT_EQ(motion.reference(), here);
}

TEST_F(Generator, APlanOfAnotherMotionIsNotAsExpected) {
  const PlannedMove move = api::MoveJoints{{{.joint = 0, .position_rad = 0.3}}};
  PlanRequest request =
      motion.request_plan(arm, {move, arm.X_FT, ToolLimitSettings(tool_maximum(setup))});
  request.steps = 5;
  PlanJob job(arm.planner, std::move(request));
  EXPECT_TRUE(motion.is_as_expected(arm, job.get())) << "at rest it is wherever it was";
  begin(0.1);
  steps(5);
  EXPECT_FALSE(motion.is_as_expected(arm, job.get()));
}

TEST_F(Generator, BrakesOnItsWay) {
  begin(1);
  steps(400);
  const double here = q0();
  motion.brake(arm, Brake::kHard);
  rest();
  EXPECT_GT(q0(), here);
  EXPECT_LT(q0(), 0.9);
}

TEST_F(Generator, StopsFromAnotherPosture) {
  begin(1);
  steps(400);
  JointVector q = motion.reference();
  q(1) += 0.01;
  motion.stop_from(arm, q);
  EXPECT_EQ(motion.reference(), q);
  rest();
  EXPECT_GT(q0(), q(0));
  motion.set_at_rest(q);
  EXPECT_TRUE(motion.at_rest());
  EXPECT_EQ(motion.reference(), q);
}

TEST_F(Generator, RetreatsAlongItsWay) {
  begin(1);
  steps(600);
  const JointVector collision = motion.reference();
  motion.set_at_rest(collision);
  motion.retreat(arm, collision);
  EXPECT_TRUE(motion.retreating());
  rest();
  EXPECT_FALSE(motion.retreating());
  EXPECT_LT(q0(), collision(0) - 0.01);
  EXPECT_GT(q0(), collision(0) - 0.1);
}

TEST_F(Generator, SpeedsMultiply) {
  const auto duration = [&](double override_fraction, double share) {
    motion.set_override(override_fraction, false);
    motion.set_speed_share(share, false);
    EXPECT_EQ(motion.override_fraction(), override_fraction);
    begin(q0() == 0 ? 0.5 : 0);
    int count = 0;
    for (; !motion.at_rest() && count < 50000; ++count) steps(1);
    return count;
  };
  duration(1, 1);
  const int full = duration(1, 1), quarter = duration(0.25, 1);
  EXPECT_EQ(duration(0.5, 0.5), quarter);
  EXPECT_GT(quarter, 2 * full);
}

TEST_F(Generator, TheDrivesGoOffAtRestUnlessAMotionIsToCome) {
  motion.switch_drives_off_after(3);
  for (int i = 0; i < 10; ++i) motion.step(arm, {}, true);
  EXPECT_TRUE(motion.drives().on());
  steps(1);
  EXPECT_FALSE(motion.drives().on());
  const double before = q0();
  begin(0.2);
  EXPECT_TRUE(motion.drives().on());
  steps(50);
  EXPECT_EQ(q0(), before) << "the brakes are still releasing";
  rest();
  EXPECT_EQ(q0(), 0.2);
}

}  // namespace
}  // namespace aprsim::robot
