#include "world/base/simd/vec4d.hpp"

#include <gtest/gtest.h>

#include "world/base/simd/vector6.hpp"

namespace aprsim::physics {
namespace {

TEST(Vec4d, ActsOnEachLane) {
  const Vec4d x = {-4, -1, 0, 9}, limit = {3, 3, 3, 3};
  const double clamped[] = {-3, -1, 0, 3}, inverse[] = {0, 0, 0, 1.0 / 9}, sizes[] = {4, 1, 0, 9};
  for (int i = 0; i < kLanes; ++i) {
    EXPECT_EQ(clamp_abs(x, limit)[i], clamped[i]);
    EXPECT_EQ(inverse_or_zero(x)[i], inverse[i]);
    EXPECT_EQ(abs(x)[i], sizes[i]);
    EXPECT_EQ(sqrt(abs(x))[i], std::sqrt(sizes[i]));
  }
}

TEST(Vec4d, ReducesAcrossLanes) {
  // Sums whose bits depend on the order of additions.
  const Vec4d a = {1, 1e-16, 1e-16, 3}, b = {0.1, 0.2, 0.3, 0.4}, c = {-1, 2, -3, 4}, d = a * b;
  const Vec4d sums = horizontal_add(a, b, c, d);
  EXPECT_EQ(sums[0], horizontal_add(a));
  EXPECT_EQ(sums[1], horizontal_add(b));
  EXPECT_EQ(sums[2], horizontal_add(c));
  EXPECT_EQ(sums[3], horizontal_add(d));
  EXPECT_EQ(horizontal_max(c), 4);
  EXPECT_TRUE(any(c < -2) && !all(c < -2) && !any(c < -3));
}

TEST(Matrix6, MultipliesAsEigenDoes) {
  const Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::Random();
  const Eigen::Matrix<double, 6, 1> x = Eigen::Matrix<double, 6, 1>::Random();
  Eigen::Matrix<double, 6, 1> product;
  Matrix6::load(m).times(x.data()).store(product.data());
  EXPECT_LT((product - m * x).norm(), 1e-14);
  Eigen::Matrix<double, 6, 6> sum = m;
  Matrix6::load(m).add_to(sum);
  EXPECT_EQ(sum, 2 * m);
}

}  // namespace
}  // namespace aprsim::physics
