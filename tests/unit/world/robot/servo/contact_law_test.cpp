#include "world/robot/servo/contact_law.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/test_arms.hpp"

namespace aprsim::robot {
namespace {

using Eigen::Vector3d;

using test::kServoStep;

TEST(NormalForce, SpringAtRest) {
  EXPECT_DOUBLE_EQ(normal_force({}, 1e-3, 0, 1 / 8.6, kServoStep), 100);
  EXPECT_EQ(normal_force({}, 0, 1, 1 / 8.6, kServoStep), 0);
  EXPECT_EQ(normal_force({}, -1e-3, 1, 1 / 8.6, kServoStep), 0);
}

TEST(NormalForce, NeverPulls) { EXPECT_EQ(normal_force({}, 1e-5, -1, 1 / 8.6, kServoStep), 0); }

TEST(NormalForce, DampingIsTheSmallerOfTheTwo) {
  // 0.7 sqrt(1e5 x 8.6) = 649 Ns/m; 0.2 x 8.6 / 1e-3 = 1720: the first.
  EXPECT_NEAR(normal_force({}, 1e-3, .1, 1 / 8.6, kServoStep), 100 + .1 * .7 * std::sqrt(8.6e5),
              1e-9);
  // 0.7 sqrt(1e5 x 0.6) = 171; 0.2 x 0.6 / 1e-3 = 120: the second.
  EXPECT_NEAR(normal_force({}, 1e-3, .1, 1 / .6, kServoStep), 100 + 12, 1e-9);
}

TEST(NormalForce, PointsShareTheStiffness) {
  EXPECT_NEAR(4 * normal_force({}, 1e-3, .1, .2, kServoStep, 4),
              normal_force({}, 1e-3, .1, .2, kServoStep), 1e-12);
}

TEST(NormalForce, ImmovablePartnersStayFinite) {
  EXPECT_TRUE(std::isfinite(normal_force({}, 1e-3, .1, 0, kServoStep)));
}

/// A mass hits the wall; the force acts one step late, as in the world.
struct Bounce {
  double worst_speed = 0, end_speed = 0, deepest = 0;
};
Bounce bounce(const ContactLaw& law, double mass, double speed, int points) {
  double x = -1e-4, v = speed, force = 0;
  Bounce out;
  for (int k = 0; k < 20000; ++k) {
    v -= force / mass * kServoStep;
    x += v * kServoStep;
    force = points * normal_force(law, x, v, 1 / mass, kServoStep, points);
    out.worst_speed = std::max(out.worst_speed, std::abs(v));
    out.deepest = std::max(out.deepest, x);
  }
  out.end_speed = std::abs(v);
  return out;
}

TEST(NormalForce, LosesEnergyForEveryMassStiffnessAndSpeed) {
  for (const double stiffness : {2e4, 1e5, 1e6, 1e7}) {
    for (const double mass : {.05, .6, 2.4, 8.6, 25.0}) {
      for (const double speed : {.05, .25, 1.0}) {
        for (const int points : {1, 4}) {
          const Bounce result = bounce({.stiffness_n_m = stiffness}, mass, speed, points);
          EXPECT_LE(result.worst_speed, speed * (1 + 1e-12));
          EXPECT_LT(result.end_speed, 0.9 * speed) << stiffness << " " << mass << " " << speed;
        }
      }
    }
  }
}

TEST(NormalForce, DepthIsThatOfTheSpring) {
  // Without damping v sqrt(m / k) = 2.3 mm; damping makes it less.
  const double deepest = bounce({}, 8.6, .25, 1).deepest;
  EXPECT_LT(deepest, .25 * std::sqrt(8.6 / 1e5));
  EXPECT_GT(deepest, .4 * .25 * std::sqrt(8.6 / 1e5));
}

TEST(Friction, OpposesTheSlipWithinTheCone) {
  const Vector3d slip(.3, -.4, 0);
  const Vector3d f = friction_force({.friction = .5}, 100, slip, 1 / 8.6, kServoStep);
  EXPECT_NEAR(f.norm(), 50, 1e-9);
  EXPECT_NEAR(f.dot(slip), -50 * .5, 1e-9);
  EXPECT_EQ(friction_force({}, 100, Vector3d::Zero(), .1, kServoStep).norm(), 0);
  EXPECT_EQ(friction_force({}, 0, slip, .1, kServoStep).norm(), 0);
}

TEST(Friction, DoesNotTurnTheSlipRound) {
  double v = .01;
  for (int k = 0; k < 200; ++k) {
    v += friction_force({}, 1000, {v, 0, 0}, 1 / .6, kServoStep).x() / .6 * kServoStep;
    ASSERT_GE(v, 0);
  }
  EXPECT_LT(v, 1e-6);
}

}  // namespace
}  // namespace aprsim::robot
