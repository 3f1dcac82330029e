#include <cmath>
#include <cstdio>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/servo/contact_law.hpp"
#include "world/robot/servo/servo_arm.hpp"

namespace aprsim::robot {
namespace {

using Eigen::Vector3d;

using test::kServoStep;

struct Case {
  const char* name;
  bool six;
  Vector3d direction;
};
void PrintTo(const Case& shown, std::ostream* out) { *out << shown.name; }

/// Acceleration of the tool along `direction` per force on it [1/kg].
double mobility(const ServoArm& arm, const Jacobian& J, const Vector3d& direction) {
  const JointVector tau = J.topRows<3>().transpose() * direction;
  return tau.dot(mass_matrix(arm.model(), arm.state().payload, arm.q()).llt().solve(tau));
}

struct Outcome {
  double peak_n = 0;  ///< greatest contact force
  int trip_ms = -1;   ///< after the first touch
  double held_n = 0;  ///< force at the end, after the stop
  double deepest_m = 0;
  bool finite = true;
};

/// The tool runs along a straight line into a wall that is in the way after 50 mm; the stop on a
/// trip is that of the world: relax, then hold.
class Collision : public testing::TestWithParam<Case> {
 protected:
  Outcome run(double speed) {
    const bool six = GetParam().six;
    const Vector3d direction = GetParam().direction;
    const ArmModel model = six ? test::fanuc() : test::motoman();
    const auto ik = *make_inverse_kinematics(model);
    const Vector3d tool_F = six ? Vector3d(.194, 0, 0) : Vector3d(0, 0, .30187);
    const Payload gripper{.mass_kg = six ? 1.3 : 4.24,
                          .com_F = 0.4 * tool_F,
                          .inertia_F = 0.003 * Eigen::Matrix3d::Identity()};
    const JointVector start = test::home(model);
    const Eigen::Isometry3d X_BF = flange_pose(model, start);
    const double elbow = ik->elbow_of(start);
    const double wall = (X_BF * tool_F).dot(direction) + 0.05;

    ServoArm arm(model, gripper, {0, 0, -9.81}, start, kServoStep);
    JointVector reference = start, tau = JointVector::Zero(model.dof());
    Outcome out;
    int touched = -1;
    bool stopped = false;
    double travel = 0, v = 0;
    for (int k = 0; k < 1500; ++k) {
      if (!stopped) {
        v = std::min(speed, v + 5 * kServoStep);
        travel += v * kServoStep;
        Eigen::Isometry3d target = X_BF;
        target.translation() += travel * direction;
        const auto q = ik->nearest(target, reference, elbow);
        if (!q) {
          ADD_FAILURE() << q.error().message;
          return out;
        }
        reference = *q;
      }
      arm.step(reference, tau);
      if (!stopped && !arm.trip_reason().empty()) {
        out.trip_ms = k - touched;
        stopped = true;
        arm.relax();
        reference = arm.q();
      }
      const Jacobian J = point_jacobian(model, arm.q(), model.dof(), tool_F);
      const double depth = (flange_pose(model, arm.q()) * tool_F).dot(direction) - wall;
      const Vector3d tool_velocity = J.topRows<3>() * arm.qd();
      const double force = normal_force({}, depth, tool_velocity.dot(direction),
                                        mobility(arm, J, direction), kServoStep);
      if (force > 0 && touched < 0) touched = k;
      tau = J.topRows<3>().transpose() * (-force * direction);
      out.peak_n = std::max(out.peak_n, force);
      out.deepest_m = std::max(out.deepest_m, depth);
      out.held_n = force;
      out.finite = out.finite && arm.q().allFinite();
    }
    std::printf("%s at %.2f m/s: peak %.0f N, trip after %d ms, %.1f mm deep, held with %.0f N\n",
                GetParam().name, speed, out.peak_n, out.trip_ms, out.deepest_m * 1e3, out.held_n);
    return out;
  }
};

TEST_P(Collision, SlowSpeedTripsQuicklyAndSoftly) {
  const Outcome out = run(0.25);
  EXPECT_TRUE(out.finite);
  EXPECT_GE(out.trip_ms, 0);
  EXPECT_LE(out.trip_ms, 10);
  EXPECT_LE(out.peak_n, 400);
  EXPECT_LT(out.held_n, out.peak_n);
  EXPECT_LT(out.deepest_m, 5e-3);
}

TEST_P(Collision, FullSpeedStaysStable) {
  const Outcome out = run(1.0);
  EXPECT_TRUE(out.finite);
  EXPECT_GE(out.trip_ms, 0);
  EXPECT_LE(out.trip_ms, 10);
  EXPECT_LT(out.peak_n, 2000);
  EXPECT_LT(out.held_n, out.peak_n);
}

INSTANTIATE_TEST_SUITE_P(Cases, Collision,
                         testing::Values(Case{"fanuc_down", true, {0, 0, -1}},
                                         Case{"fanuc_side", true, {0, 1, 0}},
                                         Case{"motoman_down", false, {0, 0, -1}},
                                         Case{"motoman_side", false, {0, 1, 0}}),
                         [](const auto& which) { return which.param.name; });

}  // namespace
}  // namespace aprsim::robot
