#include "server/listeners/visual_description.hpp"

namespace aprsim::server {
namespace {

web::RobotVisual visual_of(const scene::Robot& robot) {
  const scene::Gripper& gripper = robot.gripper;
  return {.pad_height_m = gripper.pad_height_m,
          .pad_width_m = gripper.pad_width_m,
          .pad_depth_m = gripper.pad_depth_m,
          .v_half_angle_rad = gripper.pad == scene::PadShape::kV ? gripper.v_half_angle_rad : 0,
          .palm_size = gripper.palm_size,
          .camera_V = robot.vision.camera_V,
          .area_min = robot.vision.area_min,
          .area_max = robot.vision.area_max};
}

}  // namespace

web::VisualDescription visual_of(const scene::Scene& scene) {
  web::VisualDescription visual;
  for (const auto& box : scene.fixed) visual.fixed.push_back({box.name, box.size, box.X_WS});
  for (const auto& robot : scene.robots) visual.robots.push_back(visual_of(robot));
  for (const auto& [name, gear] : scene.gear_types) {
    visual.gears.push_back({name, gear.hub_top_radius_m, gear.hub_bottom_radius_m,
                            gear.hub_height_m, gear.teeth_outer_radius_m});
  }
  for (const auto& [name, tray] : scene.tray_types) {
    auto& out = visual.trays.emplace_back();
    out.type = name;
    for (const auto& slot : tray.slots) {
      out.pockets.push_back(
          {slot.pocket.top_radius_m, slot.pocket.floor_radius_m, slot.pocket.depth_m});
    }
  }
  return visual;
}

}  // namespace aprsim::server
