#include "world/sensors/light_curtain.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::sensors {
namespace {

/// Eleven beams from x = 1 to x = 3 at y = 2, from 0.3 m up, 0.1 m apart.
api::LightCurtainDescription curtain() {
  api::LightCurtainDescription out;
  out.X_WK.p = {1, 2, 0.3};
  out.beams = 11;
  out.pitch_m = 0.1;
  out.range_m = 2;
  return out;
}

Occluder occluder(const Shape& shape, const Eigen::Vector3d& p_W) {
  Occluder out{.shape = shape, .bound_m = bounding_radius(shape)};
  out.X_WS.translation() = p_W;
  return out;
}

TEST(LightCurtain, IsClearWithNothingInIt) {
  const LightCurtain sensor(curtain());
  const std::vector<Occluder> beside{occluder(robot::BoxShape{{0.2, 0.2, 0.2}}, {2, 2.11, 0.6}),
                                     occluder(robot::SphereShape{0.1}, {0.89, 2, 0.6}),
                                     occluder(robot::SphereShape{0.1}, {3.11, 2, 0.6}),
                                     occluder(robot::SphereShape{0.09}, {2, 2, 0.2}),
                                     occluder(robot::SphereShape{0.04}, {2, 2, 0.65})};
  const auto reading = sensor.measure(beside);
  EXPECT_FALSE(reading.broken);
  for (std::size_t i = 0; i < 11; ++i) EXPECT_EQ(reading.distance_m[i], 2);
  EXPECT_EQ(reading.distance_m[11], 0) << "no such beam";
}

TEST(LightCurtain, EachBeamGivesTheDistanceToTheFirstThing) {
  const LightCurtain sensor(curtain());
  const std::vector<Occluder> things{occluder(robot::BoxShape{{0.2, 0.2, 0.2}}, {2.5, 2, 0.6}),
                                     occluder(robot::BoxShape{{0.2, 0.2, 0.05}}, {1.5, 2, 0.6})};
  const auto reading = sensor.measure(things);
  EXPECT_TRUE(reading.broken);
  EXPECT_NEAR(reading.distance_m[2], 1.4, 1e-12) << "only the box further away reaches it";
  EXPECT_NEAR(reading.distance_m[3], 0.4, 1e-12) << "the nearer of two";
  EXPECT_NEAR(reading.distance_m[4], 1.4, 1e-12);
  EXPECT_EQ(reading.distance_m[1], 2);
  EXPECT_EQ(reading.distance_m[5], 2);
}

TEST(LightCurtain, ItsFrameTurnsItsBeams) {
  // Beams straight up, side by side along -x.
  api::LightCurtainDescription up = curtain();
  up.X_WK.q = Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitY());
  const LightCurtain sensor(up);
  const std::vector<Occluder> things{occluder(robot::CylinderShape{0.04, 0.1}, {0.8, 2, 1.3})};
  const auto reading = sensor.measure(things);
  for (std::size_t i = 0; i < 11; ++i) {
    EXPECT_NEAR(reading.distance_m[i], i == 2 ? 0.95 : 2, 1e-12) << i;
  }
}

TEST(LightCurtain, SomethingAroundTheEmitterReadsZero) {
  const LightCurtain sensor(curtain());
  const std::vector<Occluder> things{occluder(robot::SphereShape{0.05}, {1, 2, 0.3})};
  EXPECT_EQ(sensor.measure(things).distance_m[0], 0);
}

/// Reference for the culling: every beam against every occluder, sampled in small steps.
TEST(LightCurtain, AgreesWithPointsAlongEveryBeam) {
  std::mt19937 random(5);
  std::uniform_real_distribution<> any(-1, 1);
  const LightCurtain sensor(curtain());
  for (int round = 0; round < 50; ++round) {
    std::vector<Occluder> things;
    for (int i = 0; i < 6; ++i) {
      const double r = 0.1 + 0.08 * any(random);
      things.push_back(occluder(
          robot::SphereShape{r},
          Eigen::Vector3d(2 + 1.3 * any(random), 2 + 0.2 * any(random), 0.8 + 0.8 * any(random))));
    }
    const auto reading = sensor.measure(things);
    bool broken = false;
    for (std::size_t beam = 0; beam < 11; ++beam) {
      double nearest = 2;
      constexpr double kStep = 1e-3;
      for (double x = 0; x < nearest; x += kStep) {
        const Eigen::Vector3d p(1 + x, 2, 0.3 + 0.1 * static_cast<double>(beam));
        for (const Occluder& thing : things) {
          const double r = std::get<robot::SphereShape>(thing.shape).radius_m;
          if ((p - thing.X_WS.translation()).norm() < r) nearest = std::min(nearest, x);
        }
      }
      if (nearest < 2 || reading.distance_m[beam] < 2) {
        broken = true;
        EXPECT_LE(reading.distance_m[beam], nearest + 1e-12);
        EXPECT_NEAR(reading.distance_m[beam], nearest, kStep + 1e-9);
      }
    }
    EXPECT_EQ(reading.broken, broken);
  }
}

}  // namespace
}  // namespace aprsim::sensors
