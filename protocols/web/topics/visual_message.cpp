#include "protocols/web/topics/visual_message.hpp"

#include "protocols/messages/write_message.hpp"

namespace aprsim::web {
namespace {

void write_appearance(const RobotVisual& robot, v1::RobotAppearance& out) {
  const auto flat = [](const Eigen::Vector2d& p) { return Eigen::Vector3d(p.x(), p.y(), 0); };
  out.set_pad_height_m(robot.pad_height_m);
  out.set_pad_width_m(robot.pad_width_m);
  out.set_pad_depth_m(robot.pad_depth_m);
  out.set_v_half_angle_rad(robot.v_half_angle_rad);
  protocols::write_message(robot.palm_size, *out.mutable_palm_size_m());
  protocols::write_message(robot.camera_V, *out.mutable_camera_m());
  protocols::write_message(flat(robot.area_min), *out.mutable_area_min_m());
  protocols::write_message(flat(robot.area_max), *out.mutable_area_max_m());
}

}  // namespace

void write_message(const VisualDescription& visual, v1::CellAppearance& out) {
  for (const FixedBoxVisual& box : visual.fixed) {
    auto& fixed = *out.add_fixed();
    fixed.set_name(box.name);
    protocols::write_message(box.size, *fixed.mutable_size_m());
    protocols::write_message(box.X_WS, *fixed.mutable_box_in_world());
  }
  for (const RobotVisual& robot : visual.robots) write_appearance(robot, *out.add_robots());
  for (const GearVisual& gear : visual.gears) {
    auto& type = *out.add_gears();
    type.set_type(gear.type);
    type.set_hub_top_radius_m(gear.hub_top_radius_m);
    type.set_hub_bottom_radius_m(gear.hub_bottom_radius_m);
    type.set_hub_height_m(gear.hub_height_m);
    type.set_teeth_radius_m(gear.teeth_radius_m);
  }
  for (const TrayVisual& tray : visual.trays) {
    auto& type = *out.add_trays();
    type.set_type(tray.type);
    for (const PocketVisual& pocket : tray.pockets) {
      auto& recess = *type.add_pockets();
      recess.set_top_radius_m(pocket.top_radius_m);
      recess.set_floor_radius_m(pocket.floor_radius_m);
      recess.set_depth_m(pocket.depth_m);
    }
  }
}

}  // namespace aprsim::web
