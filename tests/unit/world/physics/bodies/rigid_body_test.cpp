#include "world/physics/bodies/rigid_body.hpp"

#include <cstring>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

class RandomBodies {
 public:
  double number() { return normal_(random_); }
  Vector3d vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  /// A vector of any length but zero.
  Quaterniond quaternion() {
    const double w = number(), x = number(), y = number(), z = number();
    return {w, x, y, z};
  }
  RigidBody body() {
    RigidBody out;
    out.set_position(vector());
    out.set_orientation(quaternion());
    out.set_velocity(vector(), vector());
    return out;
  }

 private:
  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
};

template <typename T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

TEST(RigidBody, OrientationIsARotationWhateverTheQuaternionsLength) {
  RandomBodies random;
  for (int i = 0; i < 1000; ++i) {
    const Quaterniond q = random.quaternion();
    RigidBody body;
    body.set_orientation(q);
    EXPECT_NEAR(body.q_WB().norm(), 1, 1e-15);
    EXPECT_LT((body.R_WB() * body.R_WB().transpose() - Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_LT((body.R_WB() - q.normalized().toRotationMatrix()).norm(), 1e-14);
  }
}

TEST(RigidBody, TakesAnOrientationAsMatrixToo) {
  RandomBodies random;
  for (int i = 0; i < 100; ++i) {
    const Matrix3d R = random.quaternion().normalized().toRotationMatrix();
    RigidBody body;
    body.set_orientation(R);
    EXPECT_LT((body.R_WB() - R).norm(), 1e-14);
  }
}

// A quaternion that is scaled to unit length once more may change in its last bits.
TEST(RigidBody, RestoresAMotionBitForBit) {
  RandomBodies random;
  for (int i = 0; i < 1000; ++i) {
    const RigidBody body = random.body();
    RigidBody other = random.body();
    other.restore(body.motion());
    EXPECT_TRUE(same_bits(other.p_W(), body.p_W()));
    EXPECT_TRUE(same_bits(other.q_WB().coeffs(), body.q_WB().coeffs()));
    EXPECT_TRUE(same_bits(other.R_WB(), body.R_WB()));
    EXPECT_TRUE(same_bits(other.v_W(), body.v_W()));
    EXPECT_TRUE(same_bits(other.omega_W(), body.omega_W()));
  }
}

TEST(RigidBody, PointsOfItKeepTheirDistances) {
  RandomBodies random;
  const RigidBody body = random.body();
  EXPECT_EQ(body.velocity_at(body.p_W()), body.v_W());
  for (int i = 0; i < 100; ++i) {
    const Vector3d p = random.vector(), q = random.vector();
    EXPECT_NEAR((p - q).dot(body.velocity_at(p) - body.velocity_at(q)), 0, 1e-12);
  }
}

TEST(RigidBody, LoadIsTheSumOfForcesAndOfTheirTorquesAboutTheCentreOfMass) {
  RandomBodies random;
  RigidBody body = random.body();
  const Vector3d f = random.vector(), p = random.vector(), torque = random.vector();
  body.add_force_at(f, p);
  body.add_force_at(-f, body.p_W());
  body.add_load(Vector3d::Zero(), torque);
  EXPECT_LT(body.force_W().norm(), 1e-14);
  EXPECT_LT((body.torque_W() - torque - (p - body.p_W()).cross(f)).norm(), 1e-13);
  body.clear_load();
  EXPECT_TRUE(body.force_W().isZero(0));
  EXPECT_TRUE(body.torque_W().isZero(0));
}

TEST(RigidBody, InertiaIsSymmetric) {
  Matrix3d inertia;
  inertia << 3, 0.1, 0.2, 7, 4, 0.3, 7, 7, 5;
  RigidBody body;
  body.set_mass(2, inertia);
  EXPECT_EQ(body.mass_kg(), 2);
  EXPECT_EQ(body.inertia_B(), body.inertia_B().transpose().eval());
  EXPECT_EQ(body.inertia_B()(2, 0), 0.2);
}

}  // namespace
}  // namespace aprsim::physics
