// Trays as a camera sees them: places in pictures, and what is found in segmented ones.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "clients/ros2/trays/lens.hpp"
#include "clients/ros2/trays/tray_area.hpp"
#include "clients/ros2/trays/tray_finder.hpp"

namespace aprsim::ros2 {
namespace {

constexpr double kHeight_m = 1.5;  // of the camera over the trays' top faces
constexpr double kHalf_m = 0.08;   // of the trays' edges
constexpr double kGear_m = 0.03;   // radius

v1::Pose pose_at(double x, double y, double yaw) {
  v1::Pose pose;
  pose.mutable_position_m()->set_x(x);
  pose.mutable_position_m()->set_y(y);
  pose.mutable_orientation()->set_w(std::cos(yaw / 2));
  pose.mutable_orientation()->set_z(std::sin(yaw / 2));
  return pose;
}

v1::CameraDescription some_camera() {
  v1::CameraDescription camera;
  camera.set_name("arm_table");
  camera.set_width_px(400);
  camera.set_height_px(300);
  camera.set_focal_x_px(450);
  camera.set_focal_y_px(450);
  camera.set_centre_x_px(199.5);
  camera.set_centre_y_px(149.5);
  auto& pose = *camera.mutable_camera_in_world();  // looks down: x right, y towards -y
  pose.mutable_position_m()->set_z(kHeight_m);
  pose.mutable_orientation()->set_x(1);
  return camera;
}

/// A cell with trays that have four slots each.
v1::CellDescription some_cell(int trays) {
  v1::CellDescription cell;
  cell.add_robots()->set_name("arm");
  *cell.add_cameras() = some_camera();
  for (int i = 0; i < trays; ++i) {
    auto& tray = *cell.add_bodies();
    tray.set_name("tray_" + std::to_string(i));
    tray.set_type(i % 2 == 0 ? "sku_kit_s2l2_vessel" : "sku_small_gear_vessel");
    tray.set_kind(i % 2 == 0 ? v1::BODY_KIND_KIT_TRAY : v1::BODY_KIND_PART_TRAY);
    auto& shape = *tray.mutable_tray();
    shape.mutable_box_min_m()->set_x(-kHalf_m);
    shape.mutable_box_min_m()->set_y(-kHalf_m);
    shape.mutable_box_max_m()->set_x(kHalf_m);
    shape.mutable_box_max_m()->set_y(kHalf_m);
    for (int slot = 0; slot < 4; ++slot) {
      auto& out = *shape.add_slots();
      out.set_name("slot_" + std::to_string(slot));
      out.set_gear_type(slot < 2 ? "sku_part_small_gear" : "sku_part_large_gear");
      *out.mutable_slot_in_tray() =
          pose_at(slot % 2 == 0 ? -0.045 : 0.045, slot < 2 ? 0.045 : -0.045, 0);
    }
  }
  auto& gear = *cell.add_bodies();
  gear.set_name("gear");
  gear.set_kind(v1::BODY_KIND_GEAR);
  return cell;
}

/// Trays that do not touch, the slots that have gears, and an arm's shadow over everything on one
/// side of x.
struct Layout {
  std::vector<std::array<double, 3>> trays;  ///< x, y, yaw
  std::vector<std::array<bool, 4>> gears;
  double hidden_from_x = 1e9;
};

Layout some_layout(std::mt19937& random, int trays) {
  std::uniform_real_distribution<double> x(-0.6, 0.6), y(-0.45, 0.45), yaw(-M_PI, M_PI);
  Layout layout;
  while (static_cast<int>(layout.trays.size()) < trays) {
    const std::array<double, 3> at{x(random), y(random), yaw(random)};
    const bool is_free = std::ranges::all_of(layout.trays, [&](const auto& other) {
      return std::hypot(at[0] - other[0], at[1] - other[1]) > 2.9 * kHalf_m;
    });
    if (!is_free) continue;
    layout.trays.push_back(at);
    auto& gears = layout.gears.emplace_back();
    for (auto& gear : gears) gear = random() % 2 == 0;
  }
  return layout;
}

/// Object of a point: 0 table, 1 arm, 2 gear, 3 + i tray i.
std::uint16_t object_at(const Layout& layout, double x, double y) {
  if (x > layout.hidden_from_x) return 1;
  for (std::size_t i = 0; i < layout.trays.size(); ++i) {
    const auto& [tray_x, tray_y, yaw] = layout.trays[i];
    const double dx = x - tray_x, dy = y - tray_y;
    const double u = std::cos(yaw) * dx + std::sin(yaw) * dy;
    const double v = -std::sin(yaw) * dx + std::cos(yaw) * dy;
    if (std::abs(u) > kHalf_m || std::abs(v) > kHalf_m) continue;
    for (std::size_t slot = 0; slot < 4; ++slot) {
      const double slot_x = slot % 2 == 0 ? -0.045 : 0.045, slot_y = slot < 2 ? 0.045 : -0.045;
      if (layout.gears[i][slot] && std::hypot(u - slot_x, v - slot_y) < kGear_m) return 2;
    }
    return static_cast<std::uint16_t>(3 + i);
  }
  return 0;
}

/// The picture of a layout, ray by ray.
v1::Image picture_of(const Layout& layout) {
  const auto camera = some_camera();
  v1::Image image;
  image.set_width_px(camera.width_px());
  image.set_height_px(camera.height_px());
  *image.mutable_camera_in_world() = camera.camera_in_world();
  image.add_objects()->set_kind(v1::IMAGE_OBJECT_KIND_FIXED);
  image.add_objects()->set_kind(v1::IMAGE_OBJECT_KIND_ROBOT);
  const auto add_body = [&](const std::string& name) {
    auto& object = *image.add_objects();
    object.set_kind(v1::IMAGE_OBJECT_KIND_BODY);
    object.set_name(name);
  };
  add_body("gear");
  for (std::size_t i = 0; i < layout.trays.size(); ++i) add_body("tray_" + std::to_string(i));
  for (std::uint32_t v = 0; v < camera.height_px(); ++v) {
    for (std::uint32_t u = 0; u < camera.width_px(); ++u) {
      const double x = (u - camera.centre_x_px()) / camera.focal_x_px() * kHeight_m;
      const double y = -(v - camera.centre_y_px()) / camera.focal_y_px() * kHeight_m;
      const std::uint16_t object = object_at(layout, x, y);
      image.mutable_data()->push_back(static_cast<char>(object & 0xff));
      image.mutable_data()->push_back(static_cast<char>(object >> 8));
    }
  }
  return image;
}

BodyPoses poses_of(const Layout& layout) {
  BodyPoses poses;
  for (std::size_t i = 0; i < layout.trays.size(); ++i) {
    const auto& [x, y, yaw] = layout.trays[i];
    poses.in_world["tray_" + std::to_string(i)] = pose_at(x, y, yaw);
  }
  return poses;
}

/// The least and greatest coordinates of a tray.
std::array<double, 4> bounds_of(const std::array<double, 3>& tray) {
  const double reach = kHalf_m * (std::abs(std::cos(tray[2])) + std::abs(std::sin(tray[2])));
  return {tray[0] - reach, tray[0] + reach, tray[1] - reach, tray[1] + reach};
}

TEST(Ros2Trays, RandomTraysAreFoundWithTheirGears) {
  std::mt19937 random(5);
  const auto camera = some_camera();
  const double edge_x = (camera.centre_x_px() + 0.5) / camera.focal_x_px() * kHeight_m;
  const double edge_y = (camera.centre_y_px() + 0.5) / camera.focal_y_px() * kHeight_m;
  int found_trays = 0, outside = 0;
  for (int i = 0; i < 30; ++i) {
    const auto layout = some_layout(random, 6);
    const auto cell = some_cell(6);
    const auto trays = find_trays(cell, poses_of(layout), camera, picture_of(layout));
    std::map<std::string, const SeenTray*> by_name;
    for (const auto& tray : trays) by_name[tray.name] = &tray;
    for (std::size_t k = 0; k < layout.trays.size(); ++k) {
      const bool is_kit = k % 2 == 0;
      const std::string name =
          (is_kit ? "s2l2_kit_tray_0" : "small_gear_tray_0") + std::to_string(k);
      const auto bounds = bounds_of(layout.trays[k]);
      const double margin = std::min(
          {bounds[0] + edge_x, edge_x - bounds[1], bounds[2] + edge_y, edge_y - bounds[3]});
      if (std::abs(margin) < 0.004) continue;  // a pixel is 3.3 mm
      ASSERT_EQ(by_name.contains(name), margin > 0) << name;
      outside += margin > 0 ? 0 : 1;
      if (margin < 0) continue;
      ++found_trays;
      const SeenTray& tray = *by_name[name];
      EXPECT_EQ(tray.identifier, is_kit ? 17 : 13);
      EXPECT_EQ(tray.is_kit, is_kit);
      ASSERT_EQ(tray.slots.size(), 4U);
      for (std::size_t slot = 0; slot < 4; ++slot) {
        EXPECT_EQ(tray.slots[slot].occupied, layout.gears[k][slot]) << name << " " << slot;
        EXPECT_EQ(tray.slots[slot].size, slot < 2 ? 1 : 3);
        EXPECT_EQ(tray.slots[slot].name, name + "_slot_" + std::to_string(slot));
      }
    }
  }
  EXPECT_GT(found_trays, 60);
  EXPECT_GT(outside, 20);
}

TEST(Ros2Trays, AHiddenTrayIsNotSeen) {
  std::mt19937 random(6);
  const auto camera = some_camera();
  const auto cell = some_cell(1);
  int hidden = 0;
  for (int i = 0; i < 40; ++i) {
    std::uniform_real_distribution<double> share(0, 1);
    Layout layout{{{0, 0, 0}}, {{false, true, false, true}}, 0};
    const double visible = share(random);  // of the tray, from the left
    layout.hidden_from_x = kHalf_m * (2 * visible - 1);
    if (std::abs(visible - 0.9) < 0.05) continue;
    const auto trays = find_trays(cell, poses_of(layout), camera, picture_of(layout));
    EXPECT_EQ(trays.size(), visible > 0.9 ? 1U : 0U) << visible;
    hidden += visible > 0.9 ? 0 : 1;
  }
  EXPECT_GT(hidden, 10);
}

TEST(Ros2Trays, SlotFramesStandOnTheirTray) {
  std::mt19937 random(7);
  const auto cell = some_cell(2);
  for (int i = 0; i < 20; ++i) {
    Layout layout{{{-0.2, 0, 0.1 * i}, {0.2, 0, -0.2 * i}}, {{}, {}}, 1e9};
    const auto trays = find_trays(cell, poses_of(layout), some_camera(), picture_of(layout));
    ASSERT_EQ(trays.size(), 2U);
    const auto frames = frames_of(trays);
    ASSERT_EQ(frames.size(), 10U);  // two trays, eight slots
    for (std::size_t k = 0; k < 2; ++k) {
      const auto& [x, y, yaw] = layout.trays[k];
      for (std::size_t slot = 0; slot < 4; ++slot) {
        const Frame& frame = frames[5 * k + 1 + slot];
        const double u = slot % 2 == 0 ? -0.045 : 0.045, v = slot < 2 ? 0.045 : -0.045;
        const auto& at = frame.in_world.position_m();
        EXPECT_EQ(frame.name, trays[k].slots[slot].name);
        EXPECT_NEAR(at.x(), x + std::cos(yaw) * u - std::sin(yaw) * v, 1e-12);
        EXPECT_NEAR(at.y(), y + std::sin(yaw) * u + std::cos(yaw) * v, 1e-12);
        EXPECT_NEAR(at.z(), 0.016, 1e-12);
      }
    }
  }
}

TEST(Ros2Trays, APictureThatIsTooShortShowsNothing) {
  const Layout layout{{{0, 0, 0}}, {{}}, 1e9};
  auto image = picture_of(layout);
  image.mutable_data()->resize(image.data().size() / 4);
  EXPECT_TRUE(find_trays(some_cell(1), poses_of(layout), some_camera(), image).empty());
}

TEST(Ros2Trays, DistortedPointsComeBackByTheInverse) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> at(-0.35, 0.35), term(-0.05, 0.05);
  for (int i = 0; i < 500; ++i) {
    auto camera = some_camera();
    for (int k = 0; k < 5; ++k) camera.add_distortion(term(random) * (k == 2 || k == 3 ? 0.1 : 1));
    const double x = at(random), y = at(random);
    const auto pixel = pixel_of(camera, {2 * x, 2 * y, 2});
    ASSERT_TRUE(pixel);
    // The undistorted point by fixed-point iteration, as OpenCV finds it.
    const double u = (pixel->x() - camera.centre_x_px()) / camera.focal_x_px();
    const double v = (pixel->y() - camera.centre_y_px()) / camera.focal_y_px();
    const auto& k = camera.distortion();
    double a = u, b = v;
    for (int step = 0; step < 100; ++step) {
      const double r2 = a * a + b * b;
      const double radial = 1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2;
      const double da = 2 * k[2] * a * b + k[3] * (r2 + 2 * a * a);
      const double db = k[2] * (r2 + 2 * b * b) + 2 * k[3] * a * b;
      a = (u - da) / radial;
      b = (v - db) / radial;
    }
    EXPECT_NEAR(a, x, 1e-9);
    EXPECT_NEAR(b, y, 1e-9);
  }
  auto camera = some_camera();
  camera.add_distortion(-0.2);
  EXPECT_FALSE(pixel_of(camera, {0, 0, -1})) << "behind the camera";
  EXPECT_FALSE(pixel_of(camera, {1.5, 0, 1})) << "folded back by the distortion";
}

TEST(Ros2Trays, TopicsFollowTheCamerasNames) {
  auto cell = some_cell(0);
  const auto topic = [&](const std::string& name) {
    auto camera = some_camera();
    camera.set_name(name);
    const auto area = tray_area_of(camera, cell);
    return area ? area->topic + (area->has_frames ? "+" : "") : "";
  };
  EXPECT_EQ(topic("arm_table"), "/arm/table_trays_info+");
  EXPECT_EQ(topic("arm_conveyor"), "/arm/conveyor_trays_info+");
  EXPECT_EQ(topic("arm_belt"), "/arm/conveyor_trays_info+");
  EXPECT_EQ(topic("teach_table"), "/teach/table_trays_info");
  EXPECT_EQ(topic("table"), "");
  EXPECT_EQ(topic("_table"), "");
  EXPECT_EQ(topic("arm_overhead"), "");
  auto mounted = some_camera();
  mounted.clear_camera_in_world();
  EXPECT_FALSE(tray_area_of(mounted, cell));
  EXPECT_EQ(label_of("tray_07"), 7);
  EXPECT_EQ(label_of("tray_123"), 23);
  EXPECT_EQ(label_of("tray"), 0);
}

}  // namespace
}  // namespace aprsim::ros2
