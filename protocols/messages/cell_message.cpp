#include <variant>

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
  for (const auto& slot : body.slots) {
    auto& out = *message.add_slots();
    write_fields(slot, out);
    for (const Eigen::Vector2d& corner : slot.pocket_outline) {
      write_message(Eigen::Vector3d(corner.x(), corner.y(), 0), *out.add_pocket_outline_m());
    }
  }
}

/// The shape of a piece.
struct ShapeWriter {
  v1::Piece& message;

  void operator()(const api::BoxPiece& box) const {
    write_message(box.size, *message.mutable_box()->mutable_size_m());
  }
  void operator()(const api::ConePiece& cone) const {
    v1::ConeShape& out = *message.mutable_cone();
    out.set_bottom_radius_m(cone.bottom_radius_m);
    out.set_top_radius_m(cone.top_radius_m);
    out.set_height_m(cone.height_m);
  }
  void operator()(const api::CapsulePiece& capsule) const {
    v1::CapsuleShape& out = *message.mutable_capsule();
    out.set_radius_m(capsule.radius_m);
    out.set_length_m(capsule.length_m);
  }
  void operator()(const api::PrismPiece& prism) const {
    v1::PrismShape& out = *message.mutable_prism();
    out.set_height_m(prism.height_m);
    for (const auto& corner : prism.corners) {
      write_message(Eigen::Vector3d(corner.x(), corner.y(), 0), *out.add_corners_m());
    }
  }
  void operator()(const api::HullPiece& hull) const {
    v1::HullShape& out = *message.mutable_hull();
    for (const auto& corner : hull.corners) write_message(corner, *out.add_corners_m());
  }
};

void write(const api::Piece& piece, v1::Piece& message) {
  write_message(piece.X_BP, *message.mutable_piece_in_body());
  std::visit(ShapeWriter{message}, piece.shape);
}

void write(const api::BodyDescription& body, v1::PartGeometry& message) {
  for (const auto& piece : body.pieces) write(piece, *message.add_pieces());
  write_message(body.box_min, *message.mutable_box_min_m());
  write_message(body.box_max, *message.mutable_box_max_m());
  message.set_material(body.material);
}

void write(const api::FixtureDescription& fixture, v1::FixtureDescription& message) {
  message.set_name(fixture.name);
  write_message(fixture.X_WB, *message.mutable_fixture_in_world());
  for (const auto& piece : fixture.pieces) write(piece, *message.add_pieces());
}

void write(const api::BodyDescription& body, v1::BodyDescription& message) {
  write_fields(body, message);
  if (body.kind == api::BodyKind::kGear) {
    write(body, *message.mutable_gear());
  } else if (body.kind == api::BodyKind::kPart) {
    write(body, *message.mutable_part());
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
  for (const auto& fixture : cell.fixtures) write(fixture, *message.add_fixtures());
  for (const auto& tool : cell.tools) write(tool, *message.add_tools());
  for (const auto& camera : cell.cameras) write_message(camera, *message.add_cameras());
}

}  // namespace aprsim::protocols
