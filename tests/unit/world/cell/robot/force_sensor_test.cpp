#include "world/cell/robot/force_sensor.hpp"

#include <chrono>
#include <cmath>

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::chrono::milliseconds;

const Quaterniond kTurned(0, 0, 1, 0);

TEST(ForceSensor, IsExactWithoutErrors) {
  const ForceSensor sensor({}, 1);
  const Vector3d force(1, -0.0, 3);
  const Vector3d read = sensor.reading(force, kTurned, milliseconds(5));
  EXPECT_EQ(read, force);
  EXPECT_TRUE(std::signbit(read.y()));
}

TEST(ForceSensor, AddsBiasAndDrift) {
  const ForceSensor sensor({.bias_n = {1, 2, -35}, .drift_n_s = {0, 0.5, 0.002}, .noise_n = 0}, 1);
  const Quaterniond same = Quaterniond::Identity();
  EXPECT_TRUE(sensor.reading({0, 0, 4}, same, milliseconds(0)).isApprox(Vector3d(1, 2, -31)));
  EXPECT_TRUE(
      sensor.reading({0, 0, 4}, same, milliseconds(10000)).isApprox(Vector3d(1, 7, -30.98)));
  // They turn with the tool: its x and z point against those of the robot.
  EXPECT_TRUE(sensor.reading({0, 0, 4}, kTurned, milliseconds(0)).isApprox(Vector3d(-1, 2, 39)));
}

TEST(ForceSensor, HasNoiseOfItsOwnInEachStep) {
  const ForceSensor one({.noise_n = 0.2}, 1), other({.noise_n = 0.2}, 2);
  constexpr int kSteps = 20000;
  Vector3d mean = Vector3d::Zero(), square = Vector3d::Zero();
  double between = 0, next = 0;
  Vector3d last = Vector3d::Zero();
  for (int ms = 0; ms < kSteps; ++ms) {
    const Vector3d read = one.reading(Vector3d::Zero(), kTurned, milliseconds(ms));
    EXPECT_EQ(read, one.reading(Vector3d::Zero(), kTurned, milliseconds(ms)));
    mean += read / kSteps;
    square += read.cwiseAbs2() / kSteps;
    between += read.z() * other.reading(Vector3d::Zero(), kTurned, milliseconds(ms)).z() / kSteps;
    next += read.z() * last.z() / kSteps;
    last = read;
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(mean[i], 0, 0.006);
    EXPECT_NEAR(std::sqrt(square[i]), 0.2, 0.004);
  }
  // Neither steps nor sensors are related.
  EXPECT_NEAR(between, 0, 0.0015);
  EXPECT_NEAR(next, 0, 0.0015);
}

}  // namespace
}  // namespace aprsim::world
