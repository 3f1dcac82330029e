#include "clients/ros2/trays/tray_finder.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include "clients/ros2/trays/lens.hpp"
#include "clients/ros2/trays/tray_area.hpp"

namespace aprsim::ros2 {
namespace {

/// A type of trays in the scenes and in aprs_interfaces/msg/Tray.
struct TrayKind {
  std::string_view type;
  std::string_view name;
  std::uint8_t identifier;
};
constexpr std::array<TrayKind, 5> kKinds{{
    {"sku_small_gear_vessel", "small_gear_tray", 13},
    {"sku_medium_gear_vessel", "medium_gear_tray", 14},
    {"sku_large_gear_vessel", "large_gear_tray", 15},
    {"sku_kit_m2l1_vessel", "m2l1_kit_tray", 16},
    {"sku_kit_s2l2_vessel", "s2l2_kit_tray", 17},
}};

// aprs_vision: origin of a gear above the tray's top face; square about a slot of 30 pixels with
// 0.8466 mm each, of which an eighth has a gear's colours.
constexpr double kSlotHeight_m = 0.016;
constexpr double kSlotSquare_m = 0.0254;
constexpr double kOccupiedShare = 0.125;
constexpr int kSlotSamples = 12;  // along each edge

// A tray with less of it visible has another area, by which aprs_vision tells types apart.
constexpr double kVisibleShare = 0.9;
constexpr int kTraySamples = 24;  // along each edge of the box around it

enum class Seen { kOutside, kOther, kGear, kTray };

/// A segmented picture whose points are asked for by their place in the world.
class Picture {
 public:
  Picture(const v1::CellDescription& cell, const v1::CameraDescription& camera,
          const v1::Image& image)
      : camera_(camera),
        image_(image),
        world_in_camera_(isometry_of(image.camera_in_world()).inverse()) {
    for (const auto& body : cell.bodies()) {
      if (body.kind() == v1::BODY_KIND_GEAR) gears_.insert(body.name());
    }
  }

  /// The object at a point of a tray.
  [[nodiscard]] Seen at(const Eigen::Vector3d& in_world, const std::string& tray) const {
    const auto pixel = pixel_of(camera_, world_in_camera_ * in_world);
    if (!pixel) return Seen::kOutside;
    const double u = std::round(pixel->x()), v = std::round(pixel->y());
    if (!(u >= 0 && u < image_.width_px() && v >= 0 && v < image_.height_px())) {
      return Seen::kOutside;
    }
    const std::size_t index =
        static_cast<std::size_t>(v) * image_.width_px() + static_cast<std::size_t>(u);
    std::uint16_t number = 0;
    if ((index + 1) * sizeof number > image_.data().size()) return Seen::kOutside;
    std::memcpy(&number, image_.data().data() + index * sizeof number, sizeof number);
    if (number >= image_.objects_size()) return Seen::kOther;
    const auto& object = image_.objects(number);
    if (object.kind() != v1::IMAGE_OBJECT_KIND_BODY) return Seen::kOther;
    if (object.name() == tray) return Seen::kTray;
    return gears_.contains(object.name()) ? Seen::kGear : Seen::kOther;
  }

 private:
  const v1::CameraDescription& camera_;
  const v1::Image& image_;
  Eigen::Isometry3d world_in_camera_;
  std::set<std::string> gears_;
};

/// Corners of the top face, counter-clockwise, in the tray's frame.
std::vector<Eigen::Vector3d> outline_of(const v1::TrayGeometry& tray) {
  std::vector<Eigen::Vector3d> corners;
  for (const auto& corner : tray.outline_m()) corners.emplace_back(corner.x(), corner.y(), 0);
  if (!corners.empty()) return corners;
  const auto &low = tray.box_min_m(), &high = tray.box_max_m();
  return {{low.x(), low.y(), 0},
          {high.x(), low.y(), 0},
          {high.x(), high.y(), 0},
          {low.x(), high.y(), 0}};
}

bool is_inside(const std::vector<Eigen::Vector3d>& outline, const Eigen::Vector3d& point) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector3d& a = outline[i];
    const Eigen::Vector3d& b = outline[(i + 1) % outline.size()];
    if ((b - a).cross(point - a).z() < 0) return false;
  }
  return true;
}

/// Middles of the cells of a grid over a rectangle.
template <typename Visit>
void for_each_sample(const Eigen::Vector2d& low, const Eigen::Vector2d& high, int samples,
                     const Visit& visit) {
  const Eigen::Vector2d size = (high - low) / samples;
  for (int i = 0; i < samples; ++i) {
    for (int j = 0; j < samples; ++j) {
      const Eigen::Vector2d at = low + size.cwiseProduct(Eigen::Vector2d(i + 0.5, j + 0.5));
      visit(Eigen::Vector3d(at.x(), at.y(), 0));
    }
  }
}

bool is_seen(const Picture& picture, const std::string& name, const v1::TrayGeometry& tray,
             const Eigen::Isometry3d& tray_in_world) {
  const auto outline = outline_of(tray);
  for (const auto& corner : outline) {
    if (picture.at(tray_in_world * corner, name) == Seen::kOutside) return false;
  }
  int all = 0, visible = 0;
  for_each_sample({tray.box_min_m().x(), tray.box_min_m().y()},
                  {tray.box_max_m().x(), tray.box_max_m().y()}, kTraySamples,
                  [&](const Eigen::Vector3d& point) {
                    if (!is_inside(outline, point)) return;
                    const Seen seen = picture.at(tray_in_world * point, name);
                    ++all;
                    visible += seen == Seen::kTray || seen == Seen::kGear ? 1 : 0;
                  });
  return all > 0 && visible >= kVisibleShare * all;
}

bool is_occupied(const Picture& picture, const std::string& name, const Eigen::Vector2d& slot,
                 const Eigen::Isometry3d& tray_in_world) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * kSlotSquare_m);
  int gears = 0;
  for_each_sample(slot - half, slot + half, kSlotSamples, [&](const Eigen::Vector3d& point) {
    gears += picture.at(tray_in_world * point, name) == Seen::kGear ? 1 : 0;
  });
  return gears > kOccupiedShare * kSlotSamples * kSlotSamples;
}

std::uint8_t size_of(std::string_view gear_type) {
  if (gear_type.find("small") != std::string_view::npos) return 1;
  if (gear_type.find("medium") != std::string_view::npos) return 2;
  return gear_type.find("large") != std::string_view::npos ? 3 : 0;
}

SeenTray describe(const Picture& picture, const v1::BodyDescription& body, const TrayKind& kind,
                  const v1::Pose& in_world) {
  SeenTray tray{.identifier = kind.identifier,
                .is_kit = body.kind() == v1::BODY_KIND_KIT_TRAY,
                .name = fmt::format("{}_{:02}", kind.name, label_of(body.name())),
                .in_world = in_world,
                .slots = {}};
  const Eigen::Isometry3d tray_in_world = isometry_of(in_world);
  for (const auto& slot : body.tray().slots()) {
    auto& seen = tray.slots.emplace_back();
    const auto& at = slot.slot_in_tray().position_m();
    seen.name = tray.name + "_" + slot.name();
    seen.size = size_of(slot.gear_type());
    seen.occupied = is_occupied(picture, body.name(), {at.x(), at.y()}, tray_in_world);
    seen.in_tray = slot.slot_in_tray();
    seen.in_tray.mutable_position_m()->set_z(at.z() + kSlotHeight_m);
  }
  return tray;
}

const TrayKind* kind_of(std::string_view type) {
  for (const auto& kind : kKinds) {
    if (kind.type == type) return &kind;
  }
  return nullptr;
}

v1::Pose pose_of(const Eigen::Isometry3d& transform) {
  const Eigen::Quaterniond turn(transform.linear());
  v1::Pose pose;
  pose.mutable_position_m()->set_x(transform.translation().x());
  pose.mutable_position_m()->set_y(transform.translation().y());
  pose.mutable_position_m()->set_z(transform.translation().z());
  pose.mutable_orientation()->set_w(turn.w());
  pose.mutable_orientation()->set_x(turn.x());
  pose.mutable_orientation()->set_y(turn.y());
  pose.mutable_orientation()->set_z(turn.z());
  return pose;
}

}  // namespace

BodyPoses poses_of(const v1::Snapshot& snapshot) {
  BodyPoses poses{snapshot.epoch(), snapshot.step(), snapshot.sim_time(), {}};
  for (const auto& body : snapshot.bodies()) {
    if (!body.has_lost_step()) poses.in_world.emplace(body.name(), body.body_in_world());
  }
  return poses;
}

std::vector<SeenTray> find_trays(const v1::CellDescription& cell, const BodyPoses& poses,
                                 const v1::CameraDescription& camera,
                                 const v1::Image& segmentation) {
  const Picture picture(cell, camera, segmentation);
  std::vector<SeenTray> trays;
  for (const auto& body : cell.bodies()) {
    const TrayKind* const kind = kind_of(body.type());
    const auto pose = poses.in_world.find(body.name());
    if (!kind || !body.has_tray() || pose == poses.in_world.end()) continue;
    if (!is_seen(picture, body.name(), body.tray(), isometry_of(pose->second))) continue;
    trays.push_back(describe(picture, body, *kind, pose->second));
  }
  return trays;
}

std::vector<Frame> frames_of(const std::vector<SeenTray>& trays) {
  std::vector<Frame> frames;
  for (const auto& tray : trays) {
    frames.push_back({tray.name, tray.in_world});
    for (const auto& slot : tray.slots) {
      frames.push_back(
          {slot.name, pose_of(isometry_of(tray.in_world) * isometry_of(slot.in_tray))});
    }
  }
  return frames;
}

}  // namespace aprsim::ros2
