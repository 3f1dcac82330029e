#include "world/sensors/line_of_sight.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace aprsim::sensors {
namespace {

/// A triangle with its corner cut off, off the middle of its frame.
const scene::Outline& wedge() {
  static const scene::Outline kWedge =
      scene::outline_of({{-0.2, -0.1}, {0.3, -0.1}, {0.3, 0.05}, {-0.05, 0.4}});
  return kWedge;
}

/// Signed depth of a point below the shape's surface, written apart from the code under test.
double depth(const Shape& shape, const Eigen::Vector3d& p) {
  if (const auto* box = std::get_if<robot::BoxShape>(&shape)) {
    return (0.5 * box->size - p.cwiseAbs()).minCoeff();
  }
  if (const auto* sphere = std::get_if<robot::SphereShape>(&shape)) {
    return sphere->radius_m - p.norm();
  }
  if (const auto* cylinder = std::get_if<robot::CylinderShape>(&shape)) {
    return std::min(cylinder->radius_m - p.head<2>().norm(),
                    0.5 * cylinder->length_m - std::abs(p.z()));
  }
  if (const auto* prism = std::get_if<PrismShape>(&shape)) {
    double least = 0.5 * prism->height_m - std::abs(p.z());
    const auto& corners = prism->outline->corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d side = corners[(i + 1) % corners.size()] - corners[i];
      const Eigen::Vector2d from = p.head<2>() + prism->middle - corners[i];
      least = std::min(least, (side.x() * from.y() - side.y() * from.x()) / side.norm());
    }
    return least;
  }
  const auto& capsule = std::get<robot::CapsuleShape>(shape);
  const double z = std::clamp(p.z(), -0.5 * capsule.length_m, 0.5 * capsule.length_m);
  return capsule.radius_m - (p - Eigen::Vector3d(0, 0, z)).norm();
}

struct NamedShape {
  const char* name;
  Shape shape;
};
void PrintTo(const NamedShape& shown, std::ostream* out) { *out << shown.name; }

class LineOfSight : public testing::TestWithParam<NamedShape> {
 protected:
  std::mt19937 random{3};
  Eigen::Vector3d vector(double range) {
    std::uniform_real_distribution<> any(-range, range);
    const double x = any(random), y = any(random), z = any(random);
    return {x, y, z};
  }
};

TEST_P(LineOfSight, AgreesWithPointsAlongTheLine) {
  const Shape& shape = GetParam().shape;
  int hidden = 0, clear = 0;
  for (int round = 0; round < 2000; ++round) {
    Occluder occluder{.shape = shape, .bound_m = bounding_radius(shape)};
    occluder.X_WS =
        Eigen::Translation3d(vector(1)) * Eigen::AngleAxisd(vector(3).x(), vector(1).normalized());
    const Eigen::Vector3d a = occluder.X_WS.translation() + vector(0.6);
    const Eigen::Vector3d b = occluder.X_WS.translation() + vector(0.6);
    double deepest = -1;
    constexpr int kPoints = 400;
    for (int i = 0; i <= kPoints; ++i) {
      const Eigen::Vector3d p = a + (b - a) * i / kPoints;
      deepest = std::max(deepest, depth(shape, occluder.X_WS.inverse() * p));
    }
    if (std::abs(deepest) < 0.004) continue;  // too near to tell by points
    EXPECT_EQ(hides(occluder, a, b), deepest > 0) << "round " << round;
    if (const auto hit = first_hit(occluder, a, b)) {
      const auto depth_at = [&](double t) {
        return depth(shape, occluder.X_WS.inverse() * (a + t * (b - a)));
      };
      EXPECT_NEAR(depth_at(*hit), *hit == 0 ? depth_at(0) : 0, 1e-9)
          << "on the surface, or where the way begins inside";
      for (double t = 0; t < *hit - 1e-9; t += 0.01) EXPECT_LE(depth_at(t), 1e-9);
    }
    (deepest > 0 ? hidden : clear) += 1;
    const bool beside = distance_to_segment(occluder.X_WS.translation(), a, b) > occluder.bound_m;
    EXPECT_FALSE(beside && deepest > 0) << "the bounding sphere holds all of the shape";
  }
  EXPECT_GT(hidden, 100);
  EXPECT_GT(clear, 100);
}

INSTANTIATE_TEST_SUITE_P(Shapes, LineOfSight,
                         testing::Values(NamedShape{"Box", robot::BoxShape{{0.3, 0.5, 0.2}}},
                                         NamedShape{"Cylinder", robot::CylinderShape{0.2, 0.4}},
                                         NamedShape{"Capsule", robot::CapsuleShape{0.15, 0.4}},
                                         NamedShape{"Sphere", robot::SphereShape{0.3}},
                                         NamedShape{"Prism",
                                                    PrismShape{&wedge(), {0.05, 0.15}, 0.3}}),
                         [](const auto& test) { return test.param.name; });

TEST(LineOfSightEdges, StraightAlongTheAxes) {
  const Occluder box{.shape = robot::BoxShape{{0.2, 0.2, 0.2}}};
  EXPECT_TRUE(hides(box, {0, 0, 2}, {0, 0, -1}));
  EXPECT_FALSE(hides(box, {0, 0, 2}, {0, 0, 0.11})) << "behind the point seen";
  EXPECT_FALSE(hides(box, {0.11, 0, 2}, {0.11, 0, -1}));
  const Occluder cylinder{.shape = robot::CylinderShape{0.1, 0.2}};
  EXPECT_TRUE(hides(cylinder, {0, 0.05, 2}, {0, 0.05, -1})) << "parallel to its axis, inside";
  EXPECT_FALSE(hides(cylinder, {0.11, 0, 2}, {0.11, 0, -1})) << "parallel to its axis, outside";
  EXPECT_TRUE(hides(cylinder, {0, 0, 0}, {0, 0, 0})) << "a point inside";
}

TEST(LineOfSightEdges, DistanceToASegmentEndsAtItsEnds) {
  EXPECT_DOUBLE_EQ(distance_to_segment({0, 1, 0}, {-1, 0, 0}, {1, 0, 0}), 1);
  EXPECT_DOUBLE_EQ(distance_to_segment({4, 4, 0}, {-1, 0, 0}, {1, 0, 0}), 5);
  EXPECT_DOUBLE_EQ(distance_to_segment({3, 0, 0}, {1, 0, 0}, {1, 0, 0}), 2);
}

}  // namespace
}  // namespace aprsim::sensors
