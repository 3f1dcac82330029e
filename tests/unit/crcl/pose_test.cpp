#include <cmath>

#include <gtest/gtest.h>

#include "crcl/value_codec.hpp"

namespace aprsim::crcl {
namespace {

double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

TEST(PoseAxes, RoundedAxesBecomeExact) {
  const Result<Axes> axes = orthonormal_axes({{}, {-0.707, -0.707, 0.001}, {0, 0.002, -1.01}});
  ASSERT_TRUE(axes);
  for (const Vector& v : {axes->x, axes->y, axes->z}) EXPECT_NEAR(dot(v, v), 1, 1e-15);
  EXPECT_NEAR(dot(axes->x, axes->y), 0, 1e-15);
  EXPECT_NEAR(dot(axes->y, axes->z), 0, 1e-15);
  EXPECT_NEAR(dot(axes->z, axes->x), 0, 1e-15);
  // Y = Z x X makes it right-handed.
  EXPECT_NEAR(axes->y.x * axes->z.y - axes->y.y * axes->z.x, axes->x.z, 1e-15);
}

TEST(PoseAxes, KeepsTheDirectionOfZ) {
  const Result<Axes> axes = orthonormal_axes({{}, {1, 0, 0.3}, {0, 0, 2}});
  ASSERT_TRUE(axes);
  EXPECT_EQ(axes->z, (Vector{0, 0, 1}));
  EXPECT_EQ(axes->x, (Vector{1, 0, 0}));
  EXPECT_EQ(axes->y, (Vector{0, 1, 0}));
}

TEST(PoseAxes, LeavesExactAxesAlone) {
  const Result<Axes> axes = orthonormal_axes({{}, {1, 0, 0}, {0, 0, -1}});
  ASSERT_TRUE(axes);
  EXPECT_EQ(axes->x, (Vector{1, 0, 0}));
  EXPECT_EQ(axes->y, (Vector{0, -1, 0}));
  EXPECT_EQ(axes->z, (Vector{0, 0, -1}));
}

TEST(PoseAxes, RefusesDegenerateOnes) {
  const Result<Axes> no_z = orthonormal_axes({{}, {1, 0, 0}, {0, 0, 0}});
  ASSERT_FALSE(no_z);
  EXPECT_EQ(no_z.error().element, "ZAxis");
  EXPECT_EQ(no_z.error().value, "0 0 0");
  EXPECT_EQ(no_z.error().kind, ErrorKind::kBadValue);

  const Result<Axes> no_x = orthonormal_axes({{}, {1e-9, 0, 0}, {0, 0, 1}});
  ASSERT_FALSE(no_x);
  EXPECT_EQ(no_x.error().element, "XAxis");

  const Result<Axes> parallel = orthonormal_axes({{}, {0.01, 0, -1}, {0, 0, 1}});
  ASSERT_FALSE(parallel);
  EXPECT_EQ(parallel.error().value, "0.01 0 -1");

  EXPECT_FALSE(orthonormal_axes({{}, {1e300, 1e308, 1.7e308}, {1.7e308, 1.7e308, 1.7e308}}));
}

}  // namespace
}  // namespace aprsim::crcl
