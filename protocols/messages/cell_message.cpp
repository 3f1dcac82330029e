#include "protocols/messages/write_message.hpp"

namespace aprsim::protocols {
namespace {

void write(const api::JointDescription& joint, v1::JointDescription& message) {
  message.set_name(joint.name);
  message.set_lower_rad(joint.lower_rad);
  message.set_upper_rad(joint.upper_rad);
  message.set_max_speed_rad_s(joint.max_speed_rad_s);
  message.set_max_torque_nm(joint.max_torque_nm);
}

void write(const api::GripperDescription& gripper, v1::GripperDescription& message) {
  message.set_stroke_m(gripper.stroke_m);
  message.set_gap_open_m(gripper.gap_open_m);
  message.set_gap_closed_m(gripper.gap_closed_m);
  message.set_force_n(gripper.force_n);
  message.set_cup_radius_m(gripper.cup_radius_m);
}

void write(const api::RobotDescription& robot, v1::RobotDescription& message) {
  message.set_name(robot.name);
  message.set_model(robot.model);
  for (const auto& joint : robot.joints) write(joint, *message.add_joints());
  write_message(robot.X_WB, *message.mutable_base_in_world());
  write_message(robot.X_BR, *message.mutable_reference_in_base());
  write_message(robot.X_RV, *message.mutable_vision_in_reference());
  write_message(robot.X_FT, *message.mutable_tool_in_flange());
  if (robot.tool_point_F) {
    write_message(*robot.tool_point_F, *message.mutable_tool_point_in_flange());
  }
  write_message(robot.X_FQ, *message.mutable_coupling_in_flange());
  write(robot.gripper, *message.mutable_gripper());
  message.set_max_trans_speed_m_s(robot.max_trans_speed_m_s);
  message.set_max_trans_accel_m_s2(robot.max_trans_accel_m_s2);
  message.set_max_rot_speed_rad_s(robot.max_rot_speed_rad_s);
  message.set_max_rot_accel_rad_s2(robot.max_rot_accel_rad_s2);
}

void write(const api::BoxDescription& box, v1::Box& message) {
  write_message(box.centre, *message.mutable_centre_m());
  write_message(box.size, *message.mutable_size_m());
}

void write(const api::ToolDescription& tool, v1::ToolDescription& message) {
  message.set_name(tool.name);
  message.set_mass_kg(tool.mass_kg);
  write(tool.gripper, *message.mutable_gripper());
  write_message(tool.X_QT, *message.mutable_tool_in_coupling());
  message.set_listed(tool.listed);
  write(tool.palm, *message.mutable_palm());
  write(tool.neck, *message.mutable_neck());
  write_message(tool.finger_size, *message.mutable_finger_size_m());
  if (tool.gripper.cup_radius_m > 0) write(tool.cup, *message.mutable_cup());
  message.set_v_half_angle_rad(tool.v_half_angle_rad);
}

void write(const api::BodyDescription& body, v1::GearGeometry& message) {
  message.set_disc_radius_m(body.disc_radius_m);
  message.set_disc_height_m(body.disc_height_m);
  message.set_peg_radius_m(body.peg_radius_m);
  message.set_peg_top_m(body.peg_top_m);
}

void write(const api::BodyDescription& body, v1::TrayGeometry& message) {
  write_message(body.box_min, *message.mutable_box_min_m());
  write_message(body.box_max, *message.mutable_box_max_m());
  for (const auto& slot : body.slots) {
    auto& out = *message.add_slots();
    out.set_name(slot.name);
    out.set_gear_type(slot.gear_type);
    write_message(slot.X_PS, *out.mutable_slot_in_tray());
  }
}

void write(const api::BodyDescription& body, v1::BodyDescription& message) {
  message.set_name(body.name);
  message.set_type(body.type);
  message.set_kind(body_kind(body.kind));
  message.set_mass_kg(body.mass_kg);
  if (body.kind == api::BodyKind::kGear) {
    write(body, *message.mutable_gear());
  } else {
    write(body, *message.mutable_tray());
  }
}

v1::CurtainReaction curtain_reaction(api::CurtainReaction reaction) {
  switch (reaction) {
    case api::CurtainReaction::kNone:
      break;
    case api::CurtainReaction::kBeltStop:
      return v1::CURTAIN_REACTION_BELT_STOP;
    case api::CurtainReaction::kProtectiveStop:
      return v1::CURTAIN_REACTION_PROTECTIVE_STOP;
    case api::CurtainReaction::kAll:
      return v1::CURTAIN_REACTION_ALL;
  }
  return v1::CURTAIN_REACTION_UNSPECIFIED;
}

void write(const api::LightCurtainDescription& curtain, v1::LightCurtainDescription& message) {
  write_message(curtain.X_WK, *message.mutable_curtain_in_world());
  message.set_beams(static_cast<std::uint32_t>(curtain.beams));
  message.set_pitch_m(curtain.pitch_m);
  message.set_range_m(curtain.range_m);
  message.set_reaction(curtain_reaction(curtain.reaction));
}

}  // namespace

v1::BodyKind body_kind(api::BodyKind kind) {
  switch (kind) {
    case api::BodyKind::kGear:
      return v1::BODY_KIND_GEAR;
    case api::BodyKind::kPartTray:
      return v1::BODY_KIND_PART_TRAY;
    case api::BodyKind::kKitTray:
      return v1::BODY_KIND_KIT_TRAY;
  }
  return v1::BODY_KIND_UNSPECIFIED;
}

void write_message(const api::CellDescription& cell, v1::CellDescription& message) {
  message.set_scene(cell.scene);
  message.set_seed(cell.seed);
  write_message(cell.step_size, *message.mutable_step_size());
  for (const auto& robot : cell.robots) write(robot, *message.add_robots());
  if (cell.has_conveyor) {
    auto& conveyor = *message.mutable_conveyor();
    write_message(cell.conveyor.X_WC, *conveyor.mutable_belt_in_world());
    conveyor.set_length_m(cell.conveyor.length_m);
    conveyor.set_width_m(cell.conveyor.width_m);
    conveyor.set_max_speed_m_s(cell.conveyor.max_speed_m_s);
    conveyor.set_max_accel_m_s2(cell.conveyor.max_accel_m_s2);
    conveyor.set_max_decel_m_s2(cell.conveyor.max_decel_m_s2);
    conveyor.set_emergency_decel_m_s2(cell.conveyor.emergency_decel_m_s2);
    for (const auto& eye : cell.conveyor.photo_eyes) {
      auto& message_eye = *conveyor.add_photo_eyes();
      message_eye.set_name(eye.name);
      message_eye.set_x_m(eye.x_m);
      message_eye.set_height_m(eye.height_m);
    }
  }
  if (cell.light_curtain) write(*cell.light_curtain, *message.mutable_light_curtain());
  for (const auto& body : cell.bodies) write(body, *message.add_bodies());
  for (const auto& name : cell.fixed) message.add_fixed(name);
  for (const auto& tool : cell.tools) write(tool, *message.add_tools());
  for (const auto& type : cell.body_types) message.add_body_types(type);
}

}  // namespace aprsim::protocols
