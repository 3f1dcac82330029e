#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.hpp"
#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::ActionState;
using api::MotionLimit;

class SteadyState : public testing::TestWithParam<const char*> {
 protected:
  SteadyState() : rig(GetParam()) { rig.run(api::InitRobot{}); }

  /// Highest share of any drive's torque that the recorded references ask for.
  double highest_torque() const {
    const auto& path = rig.path();
    double highest = 0;
    for (std::size_t k = 2; k < path.size(); ++k) {
      const JointVector qd = (path[k] - path[k - 1]) * 1e3;
      const JointVector qdd = (path[k] - 2 * path[k - 1] + path[k - 2]) * 1e6;
      const JointVector torque = inverse_dynamics(rig.model(), rig.setup().payload,
                                                  rig.setup().gravity_B, path[k - 1], qd, qdd);
      for (int i = 0; i < rig.dof(); ++i) {
        highest =
            std::max(highest, std::abs(torque(i)) /
                                  rig.model().joints[static_cast<std::size_t>(i)].max_torque_nm);
      }
    }
    return highest;
  }

  ControllerRig rig;
};
INSTANTIATE_TEST_SUITE_P(Arms, SteadyState, testing::Values("fanuc", "motoman"),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(SteadyState, StepsDoNotAllocate) {
  std::mt19937 engine(17);
  int moved = 0;
  for (int n = 0; n < 60; ++n) {
    rig.run(api::InitRobot{});
    rig.apply(rig.random_command(engine));
    const auto before = aprsim::test::allocations();
    for (int i = 0; i < 600; ++i) moved += rig.controller().step().size() > 0 ? 1 : 0;
    ASSERT_EQ(aprsim::test::allocations(), before) << n;
  }
  EXPECT_EQ(moved, 60 * 600);
}

/// For any commands at any time the reference stays within the joint ranges, speeds and
/// accelerations, and comes to rest.
TEST_P(SteadyState, AnyCommandsAtAnyTimeKeepTheJointsWithinTheirLimits) {
  std::mt19937 engine(23);
  std::uniform_int_distribution<int> pause(1, 700);
  int errors = 0;
  for (int n = 0; n < 400; ++n) {
    rig.apply(rig.random_command(engine));
    if (rig.state() == ActionState::kError) {
      ++errors;
      ASSERT_NE(rig.reason(), "");
      rig.steps(pause(engine) / 4);
      rig.apply(api::InitRobot{});
    }
    rig.steps(pause(engine));
  }
  rig.rest();
  EXPECT_FALSE(rig.controller().moving());
  EXPECT_LT(errors, 250);
  for (const JointVector& q : rig.path()) {
    ASSERT_TRUE((q.array() >= rig.limits().lower.array()).all());
    ASSERT_TRUE((q.array() <= rig.limits().upper.array()).all());
  }
  const auto effort = rig.effort();
  EXPECT_LE(effort.speed, 1.01);
  EXPECT_LE(effort.accel, 1.1);
  EXPECT_LE(highest_torque(), 1.0);
}

/// Torques of the planned motions, with the payload they were planned for.
TEST_P(SteadyState, DrivesKeepATenthOfTheirTorqueInReserve) {
  for (const auto which : {MotionLimit::kTransSpeed, MotionLimit::kTransAccel,
                           MotionLimit::kRotSpeed, MotionLimit::kRotAccel}) {
    rig.run(api::SetMotionLimit{which, true, 1});
  }
  std::mt19937 engine(29);
  rig.forget();
  for (int n = 0; n < 40; ++n) {
    api::MoveJoints move = move_all(rig.random_posture(engine));
    for (auto& target : move.targets) {
      target.speed_rad_s = 100;
      target.accel_rad_s2 = 1000;
    }
    ASSERT_EQ(rig.run(move), ActionState::kDone) << rig.reason();
    ASSERT_EQ(rig.run(api::MoveTo{Pose::from(rig.X_RT(rig.random_posture(engine))), false}),
              ActionState::kDone);
  }
  const double highest = highest_torque();
  EXPECT_LE(highest, 0.95);
  EXPECT_GE(highest, 0.5);
}

}  // namespace
}  // namespace aprsim::robot
