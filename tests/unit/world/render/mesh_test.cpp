#include "world/render/mesh/mesh.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "world/render/cell/part_meshes.hpp"
#include "world/render/cell/piece_meshes.hpp"
#include "world/render/mesh/triangulation.hpp"
#include "world/scene/model/pieces.hpp"

namespace aprsim::render {
namespace {

/// Uses the divergence theorem; right only for a closed surface whose triangles all face outwards.
double volume(const Mesh& mesh) {
  double six_volumes = 0;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = triangle.points[0].cast<double>();
    const Eigen::Vector3d b = triangle.points[1].cast<double>();
    const Eigen::Vector3d c = triangle.points[2].cast<double>();
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

/// Sum of the triangles' vector areas: zero for a closed surface.
double gap(const Mesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = triangle.points[0].cast<double>();
    sum += (triangle.points[1].cast<double>() - a).cross(triangle.points[2].cast<double>() - a);
  }
  return sum.norm() / 2;
}

double regular_polygon_area(double radius, int sides) {
  return 0.5 * sides * radius * radius * std::sin(2 * std::numbers::pi / sides);
}

// Every kind of piece has all of its surface: as much volume as its mass is computed with.
TEST(Mesh, PiecesAreClosed) {
  const Pose moved{{0.1, 0.2, 0.3}, Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5)};
  const std::vector<Eigen::Vector3d> corners = {
      {0.02, 0, 0}, {-0.02, 0.01, 0}, {0, -0.03, 0}, {0, 0, 0.04}, {0.01, 0.02, 0.01}};
  const std::vector<api::Piece> pieces = {
      {api::BoxPiece{{0.02, 0.03, 0.04}}, moved},
      {api::ConePiece{0.02, 0.02, 0.03}, moved},
      {api::ConePiece{0.02, 0, 0.03}, moved},
      {api::CapsulePiece{0.02, 0}, moved},
      {api::CapsulePiece{0.01, 0.04}, moved},
      {api::PrismPiece{{{0.02, 0}, {0, 0.01}, {-0.02, 0}, {0, -0.03}}, 0.05}, moved},
      {scene::hull_of(corners), moved}};
  for (const api::Piece& piece : pieces) {
    const Mesh mesh = pieces_mesh({&piece, 1}, 0x808080);
    const double exact = scene::unit_mass_of({&piece, 1}).volume_m3;
    EXPECT_NEAR(volume(mesh), exact, 0.02 * exact) << piece.shape.index();
    EXPECT_LT(gap(mesh), 1e-8) << piece.shape.index();
  }
}

TEST(Mesh, BoxesCylindersAndSpheresAreClosed) {
  MeshBuilder box, soft, cylinder, sphere;
  box.box({0.1, 0.2, 0.3}, {1, 2, 3});
  soft.soft_box({0.1, 0.2, 0.3}, {1, 2, 3}, 0.1);
  cylinder.cylinder(0.5, -1, 2, 32);
  sphere.sphere(1, 128);
  EXPECT_NEAR(volume(box.take()), 6, 1e-5);
  const Mesh cut = soft.take();
  EXPECT_NEAR(gap(cut), 0, 1e-5);
  // Twelve edges lose a prism of c^2 / 2; at the corners three of them overlap.
  EXPECT_NEAR(volume(cut), 6 - 0.01 / 2 * 4 * (0.8 + 1.8 + 2.8) - 8 * (1e-3 - 1e-3 / 6), 1e-5);
  EXPECT_NEAR(volume(cylinder.take()), 3 * regular_polygon_area(0.5, 32), 1e-5);
  EXPECT_NEAR(volume(sphere.take()), 4 * std::numbers::pi / 3, 5e-3);
}

TEST(Mesh, TrianglesCoverAPolygonWithoutItsHoles) {
  const Outline outline = {{0, 0}, {4, 0}, {4, 3}, {2, 1.5}, {0, 3}};  // with a notch
  std::vector<Outline> holes = {circle({1, 1}, 0.4, 40), circle({3, 1}, 0.4, 40)};
  for (Outline& hole : holes) std::reverse(hole.begin(), hole.end());
  double sum = 0;
  for (const auto& [a, b, c] : triangulate(outline, holes)) {
    const Eigen::Vector2d u = b - a, v = c - a;
    const double area = (u.x() * v.y() - u.y() * v.x()) / 2;
    EXPECT_GT(area, 0);
    sum += area;
    const Eigen::Vector2d middle = (a + b + c) / 3;
    EXPECT_GT((middle - Eigen::Vector2d(1, 1)).norm(), 0.39);
    EXPECT_GT((middle - Eigen::Vector2d(3, 1)).norm(), 0.39);
  }
  EXPECT_NEAR(sum, 12 - 3 - 2 * regular_polygon_area(0.4, 40), 1e-12);
}

scene::TrayType tray_type() {
  scene::TrayType type;
  type.min_xy = {-0.08, -0.08};
  type.max_xy = {0.08, 0.08};
  type.thickness_m = 0.015;
  for (const double x : {-0.045, 0.045}) {
    type.slots.push_back(
        {.xy = {x, 0.045},
         .pocket = {.top_radius_m = 0.022, .floor_radius_m = 0.015, .depth_m = 0.0125}});
  }
  return type;
}

TEST(Mesh, ATrayIsClosedWithItsPocketsAndLabel) {
  const scene::TrayType type = tray_type();
  const auto label = place_label(type, {}, 7);
  ASSERT_TRUE(label.has_value());
  EXPECT_EQ(label->size_m, 0.04);
  EXPECT_EQ(label->centre, Eigen::Vector2d::Zero());
  const Mesh mesh = tray_mesh(type, label);
  EXPECT_NEAR(gap(mesh), 0, 1e-8);
  const double a = regular_polygon_area(0.022, 64), b = regular_polygon_area(0.015, 64);
  const double pocket = 0.0125 / 3 * (a + b + std::sqrt(a * b));
  EXPECT_NEAR(volume(mesh), 0.16 * 0.16 * 0.015 - 2 * pocket - 0.04 * 0.04 * 1e-3, 1e-9);
}

TEST(Mesh, ATrayHasPocketsOfTheirOutlines) {
  scene::TrayType type = tray_type();
  type.slots[0].pocket = {.depth_m = 0.01,
                          .outline = scene::outline_of(
                              {{-0.01, -0.005}, {0.01, -0.005}, {0.01, 0.005}, {-0.01, 0.005}})};
  type.slots[0].yaw_rad = 0.7;
  type.slots[1].pocket = {.depth_m = 0.012,
                          .outline = scene::outline_of({{0, 0}, {0.02, 0}, {0, 0.02}})};
  const Mesh mesh = tray_mesh(type, std::nullopt);
  EXPECT_NEAR(gap(mesh), 0, 1e-8);
  EXPECT_NEAR(volume(mesh), 0.16 * 0.16 * 0.015 - 0.02 * 0.01 * 0.01 - 0.02 * 0.02 / 2 * 0.012,
              1e-9);
}

TEST(Mesh, ATrayHasItsOutlineAndTheRecessOfItsType) {
  scene::TrayType type = tray_type();
  type.slots.clear();
  type.outline =
      scene::outline_of({{-0.08, -0.08}, {0.08, -0.08}, {0.08, 0}, {0, 0.08}, {-0.08, 0.08}});
  type.label = scene::LabelRecess{.size_m = 0.03, .depth_m = 0.002};
  const Mesh mesh = tray_mesh(type, place_label(type, {}, 7));
  EXPECT_NEAR(gap(mesh), 0, 1e-8);
  EXPECT_NEAR(volume(mesh), (0.16 * 0.16 - 0.08 * 0.08 / 2) * 0.015 - 0.03 * 0.03 * 0.002, 1e-9);
}

TEST(Mesh, ALabelStaysWithinTheOutline) {
  scene::TrayType type = tray_type();
  type.slots.clear();
  type.outline = scene::outline_of({{-0.08, -0.08}, {0.08, -0.08}, {-0.08, 0.05}});
  const auto label = place_label(type, {}, 7);
  ASSERT_TRUE(label.has_value());
  const double half = label->size_m / 2;
  for (const double x : {-half, half}) {
    for (const double y : {-half, half}) {
      EXPECT_GT(type.outline->depth_of(label->centre + Eigen::Vector2d(x, y)), 0);
    }
  }
}

TEST(Mesh, ALabelKeepsClearOfPockets) {
  scene::TrayType type = tray_type();
  type.slots[0].xy = {0.01, 0};
  const auto label = place_label(type, {}, 7);
  ASSERT_TRUE(label.has_value());
  const double half = label->size_m / 2;
  const Eigen::Vector2d beyond =
      ((type.slots[0].xy - label->centre).cwiseAbs().array() - half).max(0).matrix();
  EXPECT_GT(beyond.norm(), 0.022);
}

TEST(Mesh, AGearIsClosedAndHasTheSizesOfItsType) {
  scene::GearType type;
  type.disc_radius_m = type.teeth_outer_radius_m = 0.05;
  type.disc_height_m = 0.006;
  type.hub_top_radius_m = 0.03;
  type.hub_bottom_radius_m = 0.02;
  type.hub_height_m = 0.012;
  type.hub_chamfer_m = 0.0003;
  type.peg_radius_m = 0.004;
  type.peg_top_m = 0.026;
  const Mesh mesh = gear_mesh(type, 0xff0000);
  double low = 1, high = -1, wide = 0;
  for (const auto& triangle : mesh.triangles) {
    for (const auto& p : triangle.points) {
      low = std::min<double>(low, p.z());
      high = std::max<double>(high, p.z());
      wide = std::max<double>(wide, p.head<2>().norm());
    }
  }
  EXPECT_NEAR(low, -0.012, 1e-8);
  EXPECT_NEAR(high, 0.026, 1e-8);
  EXPECT_NEAR(wide, 0.05, 1e-8);
}

TEST(Mesh, AMarkersNumberIsTheOneInItsTraysName) {
  EXPECT_EQ(marker_of("small_gear_tray_07"), 7);
  EXPECT_EQ(marker_of("tray_49"), 49);
  EXPECT_EQ(marker_of("tray_52"), 2);
  EXPECT_EQ(marker_of("tray"), 0);
}

}  // namespace
}  // namespace aprsim::render
