// When a motion counts as done although something pushes the arm aside.

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;

class Arrival : public testing::Test {
 protected:
  /// Steps with the arm aside by `off` in each joint from the reference.
  void steps(int count, const JointVector& off) {
    for (int i = 0; i < count; ++i) {
      const JointVector q = rig_.controller().reference() + off;
      rig_.controller().step({.q_actual = q});
    }
  }
  JointVector off(int joint, double rad) const {
    JointVector off = JointVector::Zero(rig_.dof());
    off(joint) = rad;
    return off;
  }

  ControllerRig rig_{"fanuc"};
};

TEST_F(Arrival, AJointThatIsPushedAsideByMoreThanItsToleranceHasNotArrived) {
  rig_.run(api::InitRobot{});
  api::MoveJoints move{{{.joint = 1, .position_rad = 0.2, .speed_rad_s = {}, .accel_rad_s2 = {}}}};
  move.targets[0].tolerance_rad = 1e-3;
  rig_.apply(move);
  steps(5000, off(1, 2e-3));
  EXPECT_FALSE(rig_.controller().moving());
  EXPECT_EQ(rig_.state(), ActionState::kWorking);
  steps(1, off(0, 0.01));  // of that joint nothing was said
  EXPECT_EQ(rig_.state(), ActionState::kDone);
  EXPECT_EQ(rig_.controller().reference()(1), 0.2);
}

TEST_F(Arrival, WithoutAToleranceTheReferenceDecides) {
  rig_.run(api::InitRobot{});
  rig_.apply(
      api::MoveJoints{{{.joint = 1, .position_rad = 0.2, .speed_rad_s = {}, .accel_rad_s2 = {}}}});
  steps(5000, off(1, 5e-3));
  EXPECT_EQ(rig_.state(), ActionState::kDone);
}

TEST_F(Arrival, APoseCountsPartByPart) {
  rig_.run(api::InitRobot{});
  api::MoveTo move{rig_.tool(), true};
  move.X_RT.p.z() += 0.02;
  move.tolerance = {.x_m = {}, .y_m = 1e-3, .z_m = {}, .x_axis_rad = {}, .z_axis_rad = {}};
  rig_.apply(move);
  steps(5000, off(0, 0.01));  // some 5 mm along y
  EXPECT_EQ(rig_.state(), ActionState::kWorking);
  rig_.apply(api::StopMotion{});
  steps(10, off(0, 0.01));
  EXPECT_EQ(rig_.state(), ActionState::kDone) << "a stop is no arrival";

  move.tolerance = {.x_m = 5e-3, .y_m = {}, .z_m = {}, .x_axis_rad = {}, .z_axis_rad = {}};
  move.X_RT.p.z() -= 0.02;
  rig_.apply(move);
  steps(5000, off(0, 0.01));
  EXPECT_EQ(rig_.state(), ActionState::kDone) << "hardly off along x";
}

TEST_F(Arrival, NothingIsNearerThanTheServoCanTell) {
  rig_.run(api::InitRobot{});
  api::MoveJoints move{{{.joint = 2, .position_rad = 0.2, .speed_rad_s = {}, .accel_rad_s2 = {}}}};
  move.targets[0].tolerance_rad = 0;
  rig_.apply(move);
  steps(5000, off(2, 2e-6));
  EXPECT_EQ(rig_.state(), ActionState::kWorking);
  steps(1, off(2, 5e-7));
  EXPECT_EQ(rig_.state(), ActionState::kDone);
}

}  // namespace
}  // namespace aprsim::robot
