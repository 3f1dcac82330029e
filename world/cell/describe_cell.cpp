#include "world/cell/describe_cell.hpp"

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

api::BodyDescription describe_tray(const scene::TrayInstance& tray, const scene::TrayType& type) {
  const Eigen::AlignedBox3d slab = scene::slab_of(type);
  api::BodyDescription out;
  out.name = tray.name;
  out.type = tray.type;
  out.kind = type.kind;
  out.mass_kg = type.mass_kg;
  out.box_min = slab.min();
  out.box_max = slab.max();
  for (const auto& slot : type.slots) {
    Pose X_PS;
    X_PS.p = {slot.xy.x(), slot.xy.y(), 0};
    out.slots.push_back({.name = slot.name, .gear_type = slot.gear_type, .X_PS = X_PS});
  }
  return out;
}

api::BodyDescription describe_gear(const scene::GearInstance& gear, const scene::GearType& type) {
  const scene::GearShapes shapes = scene::shapes_of(type);
  api::BodyDescription out;
  out.name = gear.name;
  out.type = gear.type;
  out.kind = api::BodyKind::kGear;
  out.mass_kg = type.mass_kg;
  out.disc_radius_m = shapes.disc.radius_high;
  out.disc_height_m = shapes.disc.z_high;
  out.peg_radius_m = shapes.peg.radius_high;
  out.peg_top_m = shapes.peg.z_high;
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

}  // namespace

api::GripperDescription describe_gripper(const scene::Gripper& gripper) {
  return {.stroke_m = gripper.stroke_m,
          .gap_open_m = gripper.gap_open_m,
          .gap_closed_m = gripper.gap_closed_m,
          .force_n = gripper.force_n,
          .proportional = gripper.drive == scene::GripperDrive::kServo,
          .cup_radius_m = gripper.cup ? gripper.cup->radius_m : 0,
          .names = {}};
}

api::CellDescription describe_cell(const scene::Scene& scene) {
  api::CellDescription cell;
  cell.scene = scene.name;
  cell.has_conveyor = scene.conveyor.has_value();
  if (scene.conveyor) cell.conveyor = describe_conveyor(*scene.conveyor);
  cell.light_curtain = scene.light_curtain;
  for (const auto& tray : scene.trays) {
    cell.bodies.push_back(describe_tray(tray, scene.tray_types.at(tray.type)));
  }
  for (const auto& gear : scene.gears) {
    cell.bodies.push_back(describe_gear(gear, scene.gear_types.at(gear.type)));
  }
  for (const auto& [name, type] : scene.tray_types) cell.body_types.push_back(name);
  for (const auto& [name, type] : scene.gear_types) cell.body_types.push_back(name);
  cell.scene_text = std::shared_ptr<const std::string>(std::make_shared<std::string>(scene.text));
  for (const auto& tool : scene::tools_of(scene)) cell.tools.push_back(describe_tool(tool));
  return cell;
}

}  // namespace aprsim::world
