#include "world/cell/describe_cell.hpp"

#include "world/cell/machines/describe_gripper.hpp"
#include "world/scene/model/free_body.hpp"
#include "world/scene/model/part_shapes.hpp"

namespace aprsim::world {
namespace {

api::ConveyorDescription describe_conveyor(const scene::Conveyor& belt) {
  api::ConveyorDescription out{.X_WC = belt.X_WC,
                               .length_m = belt.length_m,
                               .width_m = belt.width_m,
                               .max_speed_m_s = belt.max_speed_m_s,
                               .max_accel_m_s2 = belt.max_accel_m_s2,
                               .max_decel_m_s2 = belt.max_decel_m_s2,
                               .emergency_decel_m_s2 = belt.emergency_decel_m_s2};
  for (const auto& eye : belt.photo_eyes) {
    out.photo_eyes.push_back({.name = eye.name, .x_m = eye.x_m, .height_m = eye.height_m});
  }
  return out;
}

api::BodyDescription describe_body(const scene::FreeBody& body, const scene::Scene& scene) {
  api::BodyDescription out;
  out.name = body.name;
  out.type = body.type;
  out.kind = body.kind;
  out.mass_kg = body.mass_kg;
  out.disc_radius_m = body.disc_radius_m;
  out.disc_height_m = body.disc_height_m;
  out.peg_radius_m = body.peg_radius_m;
  out.peg_top_m = body.peg_top_m;
  if (body.is_gear()) return out;
  out.box_min = body.slab.min();
  out.box_max = body.slab.max();
  if (body.is_part()) {
    out.pieces = body.pieces;
    out.material = scene.part_types.at(body.type).material;
    return out;
  }
  if (body.outline) out.outline = body.outline->corners;
  const scene::TrayType& type = scene.tray_types.at(body.type);
  if (type.label) {
    out.label_size_m = type.label->size_m;
    out.label_depth_m = type.label->depth_m;
  }
  for (const auto& slot : type.slots) {
    Pose X_PS;
    X_PS.p = {slot.xy.x(), slot.xy.y(), 0};
    X_PS.q = Eigen::AngleAxisd(slot.yaw_rad, Eigen::Vector3d::UnitZ());
    out.slots.push_back({.name = slot.name,
                         .gear_type = slot.gear_type,
                         .X_PS = X_PS,
                         .pocket_depth_m = slot.pocket.depth_m,
                         .pocket_outline = {}});
    if (slot.pocket.outline) out.slots.back().pocket_outline = slot.pocket.outline->corners;
  }
  return out;
}

api::BoxDescription describe_box(const scene::Block& block) { return {block.centre, block.size}; }

api::ToolDescription describe_tool(const scene::Tool& tool) {
  const scene::Gripper& gripper = tool.gripper;
  api::ToolDescription out;
  out.name = tool.name;
  out.mass_kg = gripper.mount_mass_kg + gripper.palm_mass_kg + 2 * gripper.finger_mass_kg;
  out.gripper = describe_gripper(gripper);
  out.X_QT = tool.X_QT;
  out.listed = !tool.own;
  out.palm = describe_box(scene::palm_of(gripper));
  out.neck = describe_box(scene::neck_of(tool));
  if (gripper.cup) {
    out.cup = describe_box(scene::cup_of(gripper));
  } else {
    out.finger_size = scene::fingers_of(gripper, gripper.gap_open_m)[0].size;
  }
  out.v_half_angle_rad = gripper.pad == scene::PadShape::kV ? gripper.v_half_angle_rad : 0;
  return out;
}

api::CameraDescription describe_camera(const scene::Camera& camera, const scene::Scene& scene) {
  const auto robot = [&scene](int index) {
    return index < 0 ? std::string() : scene.robots[static_cast<std::size_t>(index)].name;
  };
  const scene::Lens& lens = camera.lens;
  return {.name = camera.name,
          .robot = robot(camera.robot),
          .carrier = robot(camera.carrier),
          .X_PC = camera.X_PC,
          .width_px = static_cast<std::uint32_t>(lens.width_px),
          .height_px = static_cast<std::uint32_t>(lens.height_px),
          .focal_x_px = lens.focal_px.x(),
          .focal_y_px = lens.focal_px.y(),
          .centre_x_px = lens.centre_px.x(),
          .centre_y_px = lens.centre_px.y(),
          .distortion = {lens.distortion.begin(), lens.distortion.end()},
          .rate_hz = camera.rate_hz,
          .latency_s = camera.latency_s};
}

}  // namespace

api::CellDescription describe_cell(const scene::Scene& scene) {
  api::CellDescription cell;
  cell.scene = scene.name;
  cell.has_conveyor = scene.conveyor.has_value();
  if (scene.conveyor) cell.conveyor = describe_conveyor(*scene.conveyor);
  cell.light_curtain = scene.light_curtain;
  for (const auto& body : scene::free_bodies_of(scene)) {
    cell.bodies.push_back(describe_body(body, scene));
  }
  for (const auto& [name, type] : scene.tray_types) cell.body_types.push_back(name);
  for (const auto& [name, type] : scene.gear_types) cell.body_types.push_back(name);
  for (const auto& [name, type] : scene.part_types) cell.body_types.push_back(name);
  for (const auto& fixture : scene.fixtures) {
    cell.fixtures.push_back({fixture.name, fixture.X_WP, fixture.pieces});
  }
  cell.scene_text = std::shared_ptr<const std::string>(std::make_shared<std::string>(scene.text));
  for (const auto& tool : scene::tools_of(scene)) cell.tools.push_back(describe_tool(tool));
  for (const auto& camera : scene.cameras) cell.cameras.push_back(describe_camera(camera, scene));
  return cell;
}

}  // namespace aprsim::world
