#include "world/scene/model/lens.hpp"

#include <gtest/gtest.h>

namespace aprsim::scene {
namespace {

Lens laboratory_lens() {
  Lens lens;
  lens.width_px = 1920;
  lens.height_px = 1080;
  lens.focal_px = {2634, 2630};
  lens.centre_px = {959.5, 539.5};
  lens.distortion = {-0.177, 0.05, 1e-3, -2e-3, 0.01};
  return lens;
}

TEST(Lens, PixelAndDirectionAreInverses) {
  const Lens lens = laboratory_lens();
  for (int u = 0; u < lens.width_px; u += 137) {
    for (int v = 0; v < lens.height_px; v += 91) {
      const auto direction = lens.direction({u, v});
      ASSERT_TRUE(direction.has_value());
      EXPECT_LT((lens.pixel(*direction) - Eigen::Vector2d(u, v)).norm(), 1e-9);
    }
  }
}

TEST(Lens, FollowsBrownsFormula) {
  const Lens lens = laboratory_lens();
  const double x = 0.2, y = -0.1, r2 = x * x + y * y;
  const double radial = 1 - 0.177 * r2 + 0.05 * r2 * r2 + 0.01 * r2 * r2 * r2;
  const double u = x * radial + 2 * 1e-3 * x * y - 2e-3 * (r2 + 2 * x * x);
  const double v = y * radial + 1e-3 * (r2 + 2 * y * y) + 2 * -2e-3 * x * y;
  EXPECT_LT((lens.pixel({x, y}) - Eigen::Vector2d(2634 * u + 959.5, 2630 * v + 539.5)).norm(),
            1e-9);
}

TEST(Lens, HasNoDirectionBeyondItsFold) {
  Lens lens = laboratory_lens();
  lens.focal_px = {500, 500};
  lens.distortion = {-0.4, 0, 0, 0, 0};
  EXPECT_TRUE(lens.direction({959, 539}).has_value());
  EXPECT_FALSE(lens.direction({0, 0}).has_value());
}

}  // namespace
}  // namespace aprsim::scene
