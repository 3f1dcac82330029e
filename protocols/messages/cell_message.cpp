#include "protocols/messages/codecs.hpp"
#include "protocols/messages/write_message.hpp"
#include "world/api/description/description_fields.hpp"

namespace aprsim::protocols {
namespace {

void write(const api::ToolDescription& tool, v1::ToolDescription& message) {
  write_fields(tool, message);
  if (tool.gripper.cup_radius_m > 0) write_fields(tool.cup, *message.mutable_cup());
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
  for (const auto& corner : body.outline) {
    write_message(Eigen::Vector3d(corner.x(), corner.y(), body.box_max.z()),
                  *message.add_outline_m());
  }
  message.set_label_size_m(body.label_size_m);
  message.set_label_depth_m(body.label_depth_m);
  for (const auto& slot : body.slots) write_fields(slot, *message.add_slots());
}

void write(const api::BodyDescription& body, v1::BodyDescription& message) {
  write_fields(body, message);
  if (body.kind == api::BodyKind::kGear) {
    write(body, *message.mutable_gear());
  } else {
    write(body, *message.mutable_tray());
  }
}

}  // namespace

void write_message(const api::CameraDescription& camera, v1::CameraDescription& message) {
  write_fields(camera, message);
  write_message(camera.X_PC, camera.carrier.empty() ? *message.mutable_camera_in_world()
                                                    : *message.mutable_camera_in_flange());
}

void write_message(const api::CellDescription& cell, v1::CellDescription& message) {
  write_fields(cell, message);
  if (cell.has_conveyor) write_fields(cell.conveyor, *message.mutable_conveyor());
  for (const auto& body : cell.bodies) write(body, *message.add_bodies());
  for (const auto& tool : cell.tools) write(tool, *message.add_tools());
  for (const auto& camera : cell.cameras) write_message(camera, *message.add_cameras());
}

}  // namespace aprsim::protocols
