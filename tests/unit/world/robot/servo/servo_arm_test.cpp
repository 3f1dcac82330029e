#include "world/robot/servo/servo_arm.hpp"

#include <cmath>
#include <cstring>
#include <functional>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

using Eigen::Vector3d;

using test::kServoStep;
const Vector3d kGravity_W(0, 0, -9.81);

bool same_bits(const JointVector& a, const JointVector& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

/// Quintic from one posture to another, 0 <= s <= 1.
JointVector blend(const JointVector& from, const JointVector& to, double s) {
  return from + (to - from) * (s * s * s * (10 - 15 * s + 6 * s * s));
}

class Servo : public testing::TestWithParam<bool> {
 protected:
  ArmModel model_ = GetParam() ? test::fanuc() : test::motoman();
  int n_ = model_.dof();
  JointVector home_ = test::home(model_);
  JointVector zero_ = JointVector::Zero(n_);
  Payload gripper_{.mass_kg = GetParam() ? 1.3 : 4.24,
                   .com_F = GetParam() ? Vector3d(.06, 0, 0) : Vector3d(0, 0, .09),
                   .inertia_F = 0.005 * Eigen::Matrix3d::Identity()};
  Vector3d tool_F_ = GetParam() ? Vector3d(.194, 0, 0) : Vector3d(0, 0, .30187);

  ServoArm arm(const JointVector& q, ServoParameters servo = {}) {
    return ServoArm(model_, gripper_, kGravity_W, q, kServoStep, servo);
  }
  Vector3d tool(const JointVector& q) { return flange_pose(model_, q) * tool_F_; }
  JointVector torque_of(const JointVector& q, const Vector3d& force_B) {
    return point_jacobian(model_, q, n_, tool_F_).topRows<3>().transpose() * force_B;
  }
};

/// A push that would trip the drives: the brakes bear it, and the drives nothing at all.
TEST_P(Servo, BrakesHoldWhateverPresses) {
  ServoArm arm = this->arm(home_);
  const JointVector push = torque_of(home_, Vector3d(0, 300, 0));
  arm.set_braked(true);
  for (int k = 0; k < 500; ++k) arm.step(home_, push);
  EXPECT_TRUE(same_bits(arm.q(), home_));
  EXPECT_TRUE(same_bits(arm.torque(), zero_));
  EXPECT_TRUE(arm.trip_reason().empty());
  arm.set_braked(false);
  arm.step(home_, zero_);
  EXPECT_TRUE(same_bits(arm.q(), home_));
  EXPECT_TRUE(same_bits(arm.torque(), this->arm(home_).torque())) << "holds its weight again";
  for (int k = 0; k < 500 && arm.trip_reason().empty(); ++k) arm.step(home_, push);
  EXPECT_FALSE(arm.trip_reason().empty()) << "without them it trips";
}

/// An arm that is pushed aside when the brakes are applied stays there, and goes back afterwards.
TEST_P(Servo, BrakesHoldWhereItIs) {
  ServoArm arm = this->arm(home_);
  const JointVector push = torque_of(home_, Vector3d(0, 40, 0));
  for (int k = 0; k < 300; ++k) arm.step(home_, push);
  const JointVector aside = arm.q();
  ASSERT_FALSE(same_bits(aside, home_));
  arm.set_braked(true);
  for (int k = 0; k < 300; ++k) arm.step(home_, k < 100 ? push : zero_);
  EXPECT_TRUE(same_bits(arm.q(), aside));
  EXPECT_TRUE(same_bits(arm.qd(), zero_));
  arm.set_braked(false);
  for (int k = 0; k < 5000 && arm.state().deviating; ++k) arm.step(home_, zero_);
  EXPECT_TRUE(same_bits(arm.q(), home_));
}

TEST_P(Servo, TenMinutesAtRestChangeNoBit) {
  ServoArm arm = this->arm(home_);
  const Eigen::Matrix4d before = flange_pose(model_, home_).matrix();
  const JointVector torque = arm.torque();
  for (int k = 0; k < 600000; ++k) {
    arm.step(home_, zero_);
    ASSERT_TRUE(same_bits(arm.q(), home_)) << k;
  }
  EXPECT_EQ(flange_pose(model_, arm.q()).matrix(), before);
  EXPECT_TRUE(same_bits(arm.qd(), zero_));
  EXPECT_TRUE(same_bits(arm.torque(), torque));
  EXPECT_FALSE(arm.state().deviating);
}

TEST_P(Servo, HoldingTorqueIsGravity) {
  const ServoArm arm = this->arm(home_);
  EXPECT_EQ(arm.torque(), inverse_dynamics(model_, gripper_, kGravity_W, home_, zero_, zero_));
}

TEST_P(Servo, FreeMotionIsTheReferenceBitForBit) {
  std::mt19937_64 random{1};
  JointVector from = home_;
  ServoArm arm = this->arm(home_);
  for (int move = 0; move < 20; ++move) {
    const JointVector to = test::random_q(model_, random, 0.8);
    const int steps = GetParam() ? 2000 : 6000;
    for (int k = 1; k <= steps; ++k) {
      const JointVector reference = blend(from, to, static_cast<double>(k) / steps);
      arm.step(reference, zero_);
      ASSERT_TRUE(same_bits(arm.q(), reference)) << "move " << move << " step " << k;
      ASSERT_FALSE(arm.state().deviating);
    }
    from = to;
  }
  EXPECT_TRUE(arm.trip_reason().empty());
}

TEST_P(Servo, TouchBelowFrictionDoesNotMoveIt) {
  ServoArm arm = this->arm(home_);
  for (int k = 0; k < 1000; ++k) arm.step(home_, torque_of(home_, {0, 0, 1}));
  EXPECT_TRUE(same_bits(arm.q(), home_));
}

TEST_P(Servo, FiftyNewtonsGiveWayByMillimetresAndComeBackExactly) {
  for (const Vector3d& push : {Vector3d(0, 50, 0), Vector3d(50, 0, 0), Vector3d(0, 0, -50)}) {
    ServoArm arm = this->arm(home_);
    const Vector3d start = tool(home_);
    double peak = 0;
    for (int k = 0; k < 1000; ++k) {
      arm.step(home_, torque_of(arm.q(), push));
      peak = std::max(peak, (tool(arm.q()) - start).norm());
    }
    EXPECT_GT(peak, 5e-5) << push.transpose();
    EXPECT_LT(peak, 5e-3) << push.transpose();
    EXPECT_TRUE(arm.state().deviating);
    // The drives have taken up the push: what they add is what it asks beyond friction.
    const JointVector extra =
        arm.torque() - inverse_dynamics(model_, gripper_, kGravity_W, home_, zero_, zero_);
    const JointVector asked = torque_of(home_, push);
    for (int i = 0; i < n_; ++i) {
      const double friction = 0.04 * model_.joints[static_cast<std::size_t>(i)].max_torque_nm;
      EXPECT_LE(std::abs(extra(i) + asked(i)), friction + 0.05) << i;
    }
    int released = 0;
    for (; released < 2000 && arm.state().deviating; ++released) {
      arm.step(home_, zero_);
      if (released == 1200) {
        EXPECT_LT((tool(arm.q()) - start).norm(), 1e-7);
      }
    }
    EXPECT_LT(released, 2000);
    EXPECT_TRUE(same_bits(arm.q(), home_));
    EXPECT_TRUE(same_bits(arm.qd(), zero_));
    std::printf("%s, push (%g %g %g): %.2f mm peak, back after %d ms\n", model_.name.c_str(),
                push.x(), push.y(), push.z(), peak * 1e3, released);
  }
}

TEST_P(Servo, DeviationIsThatOfFullForwardDynamics) {
  // The same servo on the absolute state: what the deviation form must reproduce.
  const Vector3d push(0, 40, 0);  // within the wrist's torque, which the reference does not limit
  ServoParameters servo;
  servo.friction_fraction = 0;
  servo.integral_gain_1_s = 0;
  ServoArm arm = this->arm(home_, servo);
  JointVector q = home_, qd = zero_;
  for (int k = 0; k < 300; ++k) {
    const JointVector tau_ext = torque_of(arm.q(), push);
    const JointMatrix H = mass_matrix(model_, gripper_, q);
    const JointVector u = servo.velocity_gain_1_s * (servo.position_gain_1_s * (home_ - q) - qd);
    const JointVector drive =
        inverse_dynamics(model_, gripper_, kGravity_W, home_, zero_, zero_) + H * u;
    const JointVector bias = inverse_dynamics(model_, gripper_, kGravity_W, q, qd, zero_);
    qd += kServoStep * H.llt().solve(drive + tau_ext - bias);
    q += kServoStep * qd;
    arm.step(home_, tau_ext);
  }
  EXPECT_GT((tool(q) - tool(home_)).norm(), 1e-3);
  EXPECT_LT((tool(q) - tool(arm.q())).norm(), 0.02 * (tool(q) - tool(home_)).norm());
}

TEST_P(Servo, TooLittleTorqueLagsAndRecovers) {
  for (const double share : {0.4, 0.6, 0.8}) {
    // A move that needs more than the drives have: its peak torque is 1 / share of theirs.
    JointVector to = home_;
    to(0) = 0.6;
    to(1) = 0.35;
    const int steps = GetParam() ? 300 : 800;
    double need = 0;
    ServoArm strong = this->arm(home_);
    for (int k = 1; k <= steps; ++k) {
      strong.step(blend(home_, to, static_cast<double>(k) / steps), zero_);
      for (int i = 0; i < 2; ++i) {
        need = std::max(need, std::abs(strong.torque()(i)) /
                                  model_.joints[static_cast<std::size_t>(i)].max_torque_nm);
      }
    }
    ArmModel weak = model_;
    const JointVector hold = inverse_dynamics(model_, gripper_, kGravity_W, to, zero_, zero_);
    for (std::size_t i = 0; i < 2; ++i) {
      weak.joints[i].max_torque_nm = std::max(weak.joints[i].max_torque_nm * need * share,
                                              1.05 * std::abs(hold(static_cast<Eigen::Index>(i))));
    }
    ServoArm arm(weak, gripper_, kGravity_W, home_, kServoStep);
    double lag = 0;
    for (int k = 1; k <= steps; ++k) {
      const JointVector reference = blend(home_, to, static_cast<double>(k) / steps);
      arm.step(reference, zero_);
      lag = std::max(lag, (arm.q() - reference).cwiseAbs().maxCoeff());
      for (std::size_t i = 0; i < 2; ++i) {
        ASSERT_LE(std::abs(arm.torque()(static_cast<Eigen::Index>(i))),
                  weak.joints[i].max_torque_nm);
      }
    }
    EXPECT_GT(lag, 1e-4) << share;
    int settling = 0;
    while (settling < 20000 && arm.state().deviating) {
      arm.step(to, zero_);
      ++settling;
    }
    EXPECT_LT(settling, 20000) << share;
    EXPECT_TRUE(same_bits(arm.q(), to)) << share;
    if (lag > 0.02) {
      EXPECT_FALSE(arm.trip_reason().empty());
    }
  }
}

TEST_P(Servo, StrongPushTripsWithTheJointNamed) {
  ServoArm arm = this->arm(home_);
  JointVector tau = zero_;
  tau(1) = 0.6 * model_.joints[1].max_torque_nm;
  int steps = 0;
  while (arm.trip_reason().empty() && steps < 100) {
    arm.step(home_, tau);
    ++steps;
  }
  EXPECT_LE(steps, 20);
  EXPECT_GE(steps, 2);
  EXPECT_EQ(arm.trip_reason().find(model_.joints[1].name + ": disturbance torque"), 0u)
      << arm.trip_reason();
  arm.relax();
  EXPECT_TRUE(arm.trip_reason().empty());
}

TEST_P(Servo, LargeDeviationTrips) {
  ServoParameters servo;
  servo.trip_fraction = 10;  // leave only the other condition
  ServoArm arm = this->arm(home_, servo);
  JointVector tau = zero_;
  tau(0) = 3 * model_.joints[0].max_torque_nm;
  for (int k = 0; k < 2000 && arm.trip_reason().empty(); ++k) arm.step(home_, tau);
  EXPECT_NE(arm.trip_reason().find(": deviation from the reference 0.0"), std::string::npos)
      << arm.trip_reason();
  EXPECT_NE(arm.trip_reason().find("limit 0.02 rad"), std::string::npos);
}

TEST_P(Servo, RelaxTakesTheDeviationIntoTheReference) {
  ServoArm arm = this->arm(home_);
  JointVector tau = zero_;
  tau(1) = 0.25 * model_.joints[1].max_torque_nm;
  for (int k = 0; k < 10; ++k) arm.step(home_, tau);
  ASSERT_TRUE(arm.state().deviating);
  const JointVector here = arm.q(), speed = arm.qd();
  ASSERT_GT(speed.norm(), 0);
  arm.relax();
  EXPECT_TRUE(same_bits(arm.q(), here));
  // The push ends and the reference is at rest here: the arm brakes and stays.
  arm.step(here, zero_);
  EXPECT_LT((arm.q() - here).norm(), 2 * speed.norm() * kServoStep);
  for (int k = 0; k < 3000 && arm.state().deviating; ++k) arm.step(here, zero_);
  EXPECT_TRUE(same_bits(arm.q(), here));
}

TEST_P(Servo, RelaxInMotionKeepsTheMomentum) {
  ServoArm arm = this->arm(home_);
  JointVector to = home_;
  to(0) = 1;
  const int steps = GetParam() ? 500 : 1500;
  for (int k = 1; k <= steps / 2; ++k) {
    arm.step(blend(home_, to, static_cast<double>(k) / steps), zero_);
  }
  const JointVector here = arm.q();
  const double speed = arm.qd()(0);
  arm.relax();
  double travel = 0;
  for (int k = 0; k < 5000; ++k) {
    const double before = arm.qd()(0);
    arm.step(here, zero_);
    const double inertia = mass_matrix(model_, arm.state().payload, arm.q())(0, 0);
    // No more than the drive can brake (other joints couple in, hence the margin).
    ASSERT_LE(before - arm.qd()(0),
              3 * model_.joints[0].max_torque_nm / inertia * kServoStep + 1e-9);
    travel = std::max(travel, arm.q()(0) - here(0));
    if (!arm.state().deviating) break;
  }
  EXPECT_GT(travel, speed * speed * 0.2 * mass_matrix(model_, arm.state().payload, arm.q())(0, 0) /
                        model_.joints[0].max_torque_nm);
  EXPECT_TRUE(same_bits(arm.q(), here));
}

TEST_P(Servo, PayloadShowsInTheTorque) {
  ServoArm arm = this->arm(home_);
  const JointVector before = arm.torque();
  Payload heavier = gripper_;
  heavier.mass_kg += 1;
  arm.set_payload(heavier);
  arm.step(home_, zero_);
  EXPECT_TRUE(same_bits(arm.q(), home_));
  const JointVector change = arm.torque() - before;
  const JointVector expected =
      -(point_jacobian(model_, home_, n_, gripper_.com_F).topRows<3>().transpose() * kGravity_W);
  EXPECT_LT((change - expected).cwiseAbs().maxCoeff(), 1e-10);
}

/// A weight on the tool within the joints' friction moves nothing, and the drives bear it; beyond
/// friction the arm gives way a little, comes back, and the drives bear all of it again.
TEST_P(Servo, TheDrivesBearWhatTheToolCarries) {
  for (const double kg : {0.1, 2.0}) {
    ServoArm arm = this->arm(home_);
    const JointVector before = arm.torque();
    const JointVector load = torque_of(home_, kg * kGravity_W);
    for (int k = 0; k < 3000; ++k) arm.step(home_, load, load);
    if (kg < 1) {
      EXPECT_TRUE(same_bits(arm.q(), home_));
    }
    EXPECT_LT((arm.q() - home_).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((arm.torque() - before + load).cwiseAbs().maxCoeff(),
              0.01 * load.cwiseAbs().maxCoeff());
    EXPECT_TRUE(arm.trip_reason().empty()) << arm.trip_reason();
    for (int k = 0; k < 3000; ++k) arm.step(home_, zero_, zero_);
    EXPECT_TRUE(same_bits(arm.q(), home_));
    EXPECT_TRUE(same_bits(arm.torque(), before));
  }
}

TEST_P(Servo, SameInputsGiveTheSameBits) {
  const auto run = [&] {
    ServoArm arm = this->arm(home_);
    std::mt19937_64 random{9};
    for (int k = 0; k < 3000; ++k) {
      const double fy = k < 1500 ? std::uniform_real_distribution<double>(-80, 80)(random) : 0;
      arm.step(home_, torque_of(arm.q(), {0, fy, 0}));
    }
    return arm.q();
  };
  const JointVector first = run();
  EXPECT_TRUE(same_bits(first, run()));
  EXPECT_TRUE(same_bits(first, run()));
}

INSTANTIATE_TEST_SUITE_P(Arms, Servo, testing::Bool(),
                         [](const auto& which) { return which.param ? "fanuc" : "motoman"; });

}  // namespace
}  // namespace aprsim::robot
