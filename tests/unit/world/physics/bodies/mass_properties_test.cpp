#include "world/physics/bodies/mass_properties.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/collision/solids.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

TEST(MassProperties, AGearThatIsACylinderHasTheClosedForm) {
  scene::GearType g;
  g.disc_radius_m = 0.03;
  g.disc_height_m = 0.02;
  g.mass_kg = 0.5;
  const MassProperties m = gear_mass(g);
  EXPECT_DOUBLE_EQ(m.mass_kg, 0.5);
  EXPECT_TRUE(m.com.isApprox(Vector3d(0, 0, 0.01), 1e-14));
  EXPECT_NEAR(m.inertia(2, 2), 0.5 * 0.5 * 0.03 * 0.03, 1e-17);
  EXPECT_NEAR(m.inertia(0, 0), 0.5 * (3 * 0.03 * 0.03 + 0.02 * 0.02) / 12, 1e-17);
  EXPECT_NEAR(m.inertia(0, 1), 0, 1e-20);
}

TEST(MassProperties, DiscAndPegFollowTheParallelAxisTheorem) {
  scene::GearType g;
  g.disc_radius_m = 0.03;
  g.disc_height_m = 0.006;
  g.peg_radius_m = 0.004;
  g.peg_top_m = 0.026;
  g.mass_kg = 0.1;
  const double vd = std::numbers::pi * 0.03 * 0.03 * 0.006;
  const double vp = std::numbers::pi * 0.004 * 0.004 * 0.02;
  const double md = 0.1 * vd / (vd + vp), mp = 0.1 * vp / (vd + vp);
  const double z = (md * 0.003 + mp * 0.016) / 0.1;
  const MassProperties m = gear_mass(g);
  EXPECT_NEAR(m.com.z(), z, 1e-15);
  EXPECT_NEAR(m.inertia(2, 2), 0.5 * md * 0.03 * 0.03 + 0.5 * mp * 0.004 * 0.004, 1e-17);
  const double across = md * (3 * 0.03 * 0.03 + 0.006 * 0.006) / 12 + md * std::pow(0.003 - z, 2) +
                        mp * (3 * 0.004 * 0.004 + 0.02 * 0.02) / 12 + mp * std::pow(0.016 - z, 2);
  EXPECT_NEAR(m.inertia(1, 1), across, 1e-17);
}

TEST(MassProperties, AConeShapedHubHasTheFrustumsClosedForm) {
  scene::GearType g = test::conical_gear();
  g.disc_height_m = 1e-12;  // nothing but the hub
  g.peg_top_m = 0;
  const double a = g.hub_top_radius_m, b = g.hub_bottom_radius_m, h = g.hub_height_m;
  const MassProperties m = gear_mass(g);
  const double izz =
      0.3 * g.mass_kg * (std::pow(a, 5) - std::pow(b, 5)) / (std::pow(a, 3) - std::pow(b, 3));
  EXPECT_NEAR(m.inertia(2, 2), izz, 1e-9 * izz);
  const double below_top = h / 4 * (a * a + 2 * a * b + 3 * b * b) / (a * a + a * b + b * b);
  EXPECT_NEAR(m.com.z(), -below_top, 1e-9);
}

TEST(MassProperties, MatchesVoxelsOfTheSameSolids) {
  const scene::GearType g = test::cylindrical_gear();
  const double step = 4e-4;
  double volume = 0, iz = 0, first = 0;
  for (double z = -0.006 + step / 2; z < 0.024; z += step) {
    for (double x = -0.030 + step / 2; x < 0.030; x += step) {
      for (double y = -0.030 + step / 2; y < 0.030; y += step) {
        if (test::gear_distance(g, {x, y, z}) > 0) continue;
        volume += 1;
        first += z;
        iz += x * x + y * y;
      }
    }
  }
  const MassProperties m = gear_mass(g);
  EXPECT_NEAR(m.com.z(), first / volume, 3e-5);
  EXPECT_NEAR(m.inertia(2, 2), g.mass_kg * iz / volume, 2e-3 * m.inertia(2, 2));
}

TEST(MassProperties, ASlabWithoutPocketsIsABox) {
  scene::TrayType t = test::conical_tray();
  t.slots.clear();
  t.min_xy = {-0.105, -0.025};
  t.max_xy = {0.105, 0.113};
  const MassProperties m = tray_mass(t);
  EXPECT_TRUE(m.com.isApprox(Vector3d(0, 0.044, -0.0075), 1e-13));
  EXPECT_NEAR(m.inertia(0, 0), 0.2 * (0.138 * 0.138 + 0.015 * 0.015) / 12, 1e-16);
  EXPECT_NEAR(m.inertia(2, 2), 0.2 * (0.138 * 0.138 + 0.21 * 0.21) / 12, 1e-16);
}

TEST(MassProperties, ARectangularOutlineWeighsAsItsBox) {
  scene::TrayType t = test::conical_tray();
  t.min_xy = {-0.105, -0.025};
  t.max_xy = {0.105, 0.113};
  t.slots.clear();
  t.label = scene::LabelRecess{.size_m = 0.04, .depth_m = 0.001};
  const MassProperties box = tray_mass(t);
  t.outline = scene::outline_of(test::corners_of(t));
  const MassProperties prism = tray_mass(t);
  EXPECT_LT((prism.com - box.com).norm(), 1e-15);
  EXPECT_LT((prism.inertia - box.inertia).norm(), 1e-16);
}

TEST(MassProperties, AWedgeMatchesVoxels) {
  scene::TrayType t = test::wedge_tray();
  t.label = scene::LabelRecess{.size_m = 0.04, .depth_m = 0.001};
  const double step = 5e-4;
  double volume = 0;
  Vector3d first = Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (double z = -t.thickness_m + step / 2; z < 0; z += step) {
    for (double x = t.min_xy.x() + step / 2; x < t.max_xy.x(); x += step) {
      for (double y = t.min_xy.y() + step / 2; y < t.max_xy.y(); y += step) {
        const Vector3d p(x, y, z);
        const bool in_label = z > -0.001 && std::abs(x) < 0.02 && std::abs(y) < 0.02;
        if (in_label || test::tray_distance(t, p) > 0) continue;
        volume += 1;
        first += p;
        second += p * p.transpose();
      }
    }
  }
  const MassProperties m = tray_mass(t);
  const Vector3d com = first / volume;
  const Eigen::Matrix3d central = t.mass_kg * (second / volume - com * com.transpose());
  const Eigen::Matrix3d inertia = central.trace() * Eigen::Matrix3d::Identity() - central;
  // Voxels err in proportion to their edge: of 1, 0.5 and 0.25 mm, by 77, 35 and 18 um in the
  // centre of mass and by 1.2, 0.6 and 0.3 thousandths of the inertia.
  EXPECT_LT((m.com - com).norm(), 0.1 * step);
  EXPECT_LT((m.inertia - inertia).norm(), 2 / 1e3 * (step / 1e-3) * m.inertia.norm());
}

TEST(MassProperties, PocketsTakeTheirShareOfATray) {
  const scene::TrayType t = test::cylindrical_tray();
  const MassProperties m = tray_mass(t);
  const double box = 0.16 * 0.16 * 0.015;
  const double r = 0.0103, R = 0.0113;
  const double bore = std::numbers::pi * r * r * 0.0055;
  const double cone = std::numbers::pi * 0.001 * (r * r + r * R + R * R) / 3;
  const double cone_z = -0.001 / 4 * (R * R + 2 * R * r + 3 * r * r) / (R * R + R * r + r * r);
  const double z =
      (box * -0.0075 - 4 * (bore * -0.00375 + cone * cone_z)) / (box - 4 * (bore + cone));
  EXPECT_NEAR(m.com.z(), z, 1e-12);
  EXPECT_NEAR(m.com.x(), 0, 1e-15);
  EXPECT_GT(m.inertia.determinant(), 0);
  EXPECT_NEAR(m.inertia(0, 0), m.inertia(1, 1), 1e-15);
}

// A pocket with an outline, turned and chamfered, against voxels.
TEST(MassProperties, AnOutlinedPocketMatchesVoxels) {
  scene::TrayType t = test::conical_tray();
  t.slots.clear();
  t.min_xy = {-0.03, -0.02};
  t.max_xy = {0.03, 0.02};
  t.thickness_m = 0.02;
  scene::Slot slot;
  slot.xy = {0.01, -0.002};
  slot.yaw_rad = 0.4;
  slot.pocket.depth_m = 0.015;
  slot.pocket.chamfer_m = 0.004;
  slot.pocket.chamfer_angle_rad = 0.6;
  slot.pocket.outline = scene::outline_of({{-0.01, -0.006}, {0.012, -0.004}, {-0.004, 0.01}});
  t.slots.push_back(slot);
  const double step = 2.5e-4;
  double volume = 0;
  Vector3d first = Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (double z = -t.thickness_m + step / 2; z < 0; z += step) {
    const double by = std::max(0.0, slot.pocket.chamfer_m + z) * std::tan(0.6);
    const scene::Outline hole =
        scene::placed(scene::widened(*slot.pocket.outline, by), slot.xy, slot.yaw_rad);
    for (double x = t.min_xy.x() + step / 2; x < t.max_xy.x(); x += step) {
      for (double y = t.min_xy.y() + step / 2; y < t.max_xy.y(); y += step) {
        if (z > -slot.pocket.depth_m && hole.depth_of({x, y}) > 0) continue;
        const Vector3d p(x, y, z);
        volume += 1;
        first += p;
        second += p * p.transpose();
      }
    }
  }
  const MassProperties m = tray_mass(t);
  const Vector3d com = first / volume;
  const Eigen::Matrix3d central = t.mass_kg * (second / volume - com * com.transpose());
  const Eigen::Matrix3d inertia = central.trace() * Eigen::Matrix3d::Identity() - central;
  EXPECT_LT((m.com - com).norm(), 0.05 * step);
  EXPECT_LT((m.inertia - inertia).norm(), 1e-3 * m.inertia.norm());
}

}  // namespace
}  // namespace aprsim::physics
