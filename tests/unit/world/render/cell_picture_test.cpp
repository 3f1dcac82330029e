// Pictures of a shipped scene.

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/case_count.hpp"
#include "world/cell/world.hpp"
#include "world/render/cell/cell_model.hpp"
#include "world/render/cell/part_meshes.hpp"
#include "world/render/mesh/aruco.hpp"
#include "world/render/renderer.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::render {
namespace {

/// Nearest triangle that a ray meets from its front, by Cramer's rule (Moeller and Trumbore 1997)
/// in double precision; independent of the rasteriser.
class RayCaster {
 public:
  explicit RayCaster(const std::vector<Placement>& placements) : placements_(placements) {
    for (const Placement& placement : placements) {
      Ball ball;
      for (const auto& triangle : placement.mesh->triangles) {
        for (const auto& p : triangle.points) ball.radius = std::max<double>(ball.radius, p.norm());
      }
      ball.centre = placement.X_W.translation();
      // Scaled placements: the box of an intruder.
      ball.radius *= std::max(1.0, placement.X_W.linear().norm());
      balls_.push_back(ball);
    }
  }

  struct Hit {
    std::size_t placement = 0;
    double distance = 0;
  };

  /// The nearest surface, and those of other things in the same plane.
  [[nodiscard]] std::vector<Hit> cast(const Eigen::Vector3d& from,
                                      const Eigen::Vector3d& direction) const {
    constexpr double kSamePlane_m = 1e-6;
    std::vector<Hit> hits;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < placements_.size(); ++i) {
      const Eigen::Vector3d to = balls_[i].centre - from;
      const Eigen::Vector3d off = to - direction * (to.dot(direction) / direction.squaredNorm());
      if (off.norm() > balls_[i].radius) continue;
      const Eigen::Isometry3d& X = placements_[i].X_W;
      for (const auto& triangle : placements_[i].mesh->triangles) {
        const Eigen::Vector3d a = X * triangle.points[0].cast<double>();
        const Eigen::Vector3d u = X * triangle.points[1].cast<double>() - a;
        const Eigen::Vector3d v = X * triangle.points[2].cast<double>() - a;
        const Eigen::Vector3d p = direction.cross(v);
        const double determinant = u.dot(p);
        if (!(determinant > 0)) continue;
        const Eigen::Vector3d t = from - a, q = t.cross(u);
        const double s = t.dot(p), r = direction.dot(q);
        if (s < 0 || r < 0 || s + r > determinant) continue;
        const double distance = v.dot(q) / determinant;
        if (distance <= 0 || distance > nearest + kSamePlane_m) continue;
        nearest = std::min(nearest, distance);
        hits.push_back({i, distance});
      }
    }
    std::erase_if(hits, [&](const Hit& hit) { return hit.distance > nearest + kSamePlane_m; });
    return hits;
  }

 private:
  struct Ball {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double radius = 0;
  };
  const std::vector<Placement>& placements_;
  std::vector<Ball> balls_;
};

class CellPicture : public testing::Test {
 protected:
  CellPicture()
      : scene_(std::make_shared<const scene::Scene>(
            scene::load_scene("aprs_2024", scene::default_data_paths()).value())),
        world_(scene_, 1),
        snapshot_(snapshot_of(world_)),
        model_(CellModel::make(*scene_, *snapshot_.cell).value()) {
    camera_.X_PC.p = {0.25, -0.95, 2.5};
    camera_.X_PC.q = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
    camera_.lens.width_px = 960;
    camera_.lens.height_px = 540;
    camera_.lens.focal_px = {1100, 1100};
    camera_.lens.centre_px = {479.5, 269.5};
    camera_.lens.distortion = {-0.18, 0, 0, 0, 0};
  }

  static api::Snapshot snapshot_of(const world::World& world) {
    api::Snapshot snapshot;
    world.write(snapshot);
    return snapshot;
  }

  std::shared_ptr<const scene::Scene> scene_;
  world::World world_;
  api::Snapshot snapshot_;
  CellModel model_;
  scene::Camera camera_;
};

TEST_F(CellPicture, SegmentsAreThoseOfIndependentRays) {
  Renderer renderer(camera_, {}, 1);
  const std::vector<Placement>& placements = model_.place(snapshot_);
  renderer.draw(placements, 1, 2);
  const Picture<std::uint16_t> segments = renderer.segments(model_.object_of());
  const Picture<float> depth = renderer.depth();
  const RayCaster rays(placements);
  std::mt19937 random(1);
  std::set<std::uint16_t> seen;
  for (int i = 0; i < test::case_count(100000); ++i) {
    const int x = static_cast<int>(random() % 960), y = static_cast<int>(random() % 540);
    const Eigen::Vector2d d = *camera_.lens.direction({x, y});
    const auto hits = rays.cast(camera_.X_PC.p, camera_.X_PC.q * Eigen::Vector3d(d.x(), d.y(), 1));
    ASSERT_FALSE(hits.empty());
    ASSERT_TRUE(std::ranges::any_of(hits,
                                    [&](const RayCaster::Hit& hit) {
                                      return model_.object_of()[hit.placement] ==
                                             *segments.at(x, y);
                                    }))
        << x << ' ' << y;
    ASSERT_NEAR(*depth.at(x, y), hits.front().distance, 2e-5) << x << ' ' << y;
    seen.insert(*segments.at(x, y));
  }
  EXPECT_GT(seen.size(), 12U);
}

TEST_F(CellPicture, MarkersCanBeReadFromThePicture) {
  camera_.X_PC.p = {0.375, -1.02, 1.6};
  Renderer renderer(camera_, lamps_over(model_.extent()), 1);
  renderer.draw(model_.place(snapshot_), 1, 2);
  int read = 0;
  for (std::size_t i = 0; i < snapshot_.cell->bodies.size(); ++i) {
    const api::BodyDescription& body = snapshot_.cell->bodies[i];
    if (body.name != "medium_gear_vessel_1") continue;
    const auto label = place_label(scene_->tray_types.at(body.type), scene_->gear_types, 1);
    ASSERT_TRUE(label.has_value());
    for (int row = 0; row < kMarkerCells; ++row) {
      for (int column = 0; column < kMarkerCells; ++column) {
        const double cell = kMarkerShare * label->size_m / kMarkerCells;
        const Eigen::Vector3d p_P(label->centre.x() + (column - 3) * cell,
                                  label->centre.y() - (row - 3) * cell, -kLabelDepth_m);
        const Eigen::Vector3d p_W = snapshot_.bodies[i].X_WB.isometry() * p_P;
        const Eigen::Vector3d p = camera_.X_PC.isometry().inverse() * p_W;
        const Eigen::Vector2d pixel = camera_.lens.pixel(p.head<2>() / p.z());
        const int code = *renderer.rgb().at(static_cast<int>(std::lround(pixel.x())),
                                            static_cast<int>(std::lround(pixel.y())));
        EXPECT_EQ(code > 128, marker_is_white(1, row, column)) << row << ' ' << column;
        ++read;
      }
    }
  }
  EXPECT_EQ(read, kMarkerCells * kMarkerCells);
}

TEST_F(CellPicture, TraysAreDarkAndTheTableIsBright) {
  Renderer renderer(camera_, lamps_over(model_.extent()), 1);
  renderer.draw(model_.place(snapshot_), 1, 2);
  const Picture<std::uint16_t> segments = renderer.segments(model_.object_of());
  double tray = 0, table = 0;
  int trays = 0, tables = 0;
  for (int y = 0; y < 540; ++y) {
    for (int x = 0; x < 960; ++x) {
      const std::string& name = model_.objects()[*segments.at(x, y)].name;
      const std::uint8_t* rgb = renderer.rgb().at(x, y);
      const int value = std::max({rgb[0], rgb[1], rgb[2]});
      if (name == "kit_m2l1_vessel_1" || name == "kit_m2l1_vessel_2") {
        tray += value;
        ++trays;
      } else if (name == "fanuc_table") {
        table += value;
        ++tables;
      }
    }
  }
  ASSERT_GT(trays, 1000);
  ASSERT_GT(tables, 1000);
  EXPECT_LT(tray / trays, 90);
  EXPECT_GT(table / tables, 190);
}

TEST_F(CellPicture, TheFlangeIsWhereTheToolHangs) {
  ASSERT_FALSE(model_.place(snapshot_).empty());
  for (std::size_t i = 0; i < scene_->robots.size(); ++i) {
    const Eigen::Isometry3d X_WT = model_.X_WF(i) * scene_->robots[i].X_FT.isometry();
    const auto& tool = snapshot_.tools.at(static_cast<std::size_t>(snapshot_.robots.at(i).tool));
    EXPECT_LT((X_WT.translation() - tool.X_WT.p).norm(), 1e-3) << i;
    EXPECT_LT((X_WT.linear() - tool.X_WT.isometry().linear()).norm(), 1e-3) << i;
  }
}

}  // namespace
}  // namespace aprsim::render
