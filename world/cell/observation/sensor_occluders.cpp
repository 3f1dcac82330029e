#include "world/cell/observation/sensor_occluders.hpp"

#include <algorithm>
#include <cstddef>

#include "world/scene/model/part_shapes.hpp"

namespace aprsim::world {
namespace {

constexpr std::size_t kToolOccluders = 4, kGearOccluders = 3;
constexpr double kOutOfSight_m = 1e6;  // to the side of every camera's area

}  // namespace

SensorOccluders::SensorOccluders(const scene::Scene& scene, std::span<const robot::ArmModel> models)
    : models_(models), tools_(scene::tools_of(scene)) {
  for (const auto& tray : scene.trays) trays_.push_back(&scene.tray_types.at(tray.type));
  for (const auto& gear : scene.gears) gears_.push_back(&scene.gear_types.at(gear.type));
  for (const auto& part : scene.parts) parts_.push_back(&scene.part_types.at(part.type));
  X_WP_.resize(trays_.size() + gears_.size() + parts_.size());
  std::size_t count = trays_.size() + kGearOccluders * gears_.size() + 1;
  for (const scene::PartType* part : parts_) count += part->pieces.size();
  for (const auto& model : models) {
    for (const auto& link : model.links) count += link.collision.size();
  }
  count += kToolOccluders * tools_.size();
  occluders_.reserve(count);
}

void SensorOccluders::gather(std::span<const SimulatedRobot> robots,
                             const physics::PhysicsWorld& physics,
                             std::span<const api::Intruder> intruders) {
  occluders_.clear();
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const auto X_WL = robots[i].X_WL();
    for (std::size_t link = 0; link < X_WL.size(); ++link) {
      for (const auto& part : models_[i].links[link].collision) {
        add(X_WL[link] * part.X_LS, sensors::shape_of(part));
      }
    }
  }
  for (int i = 0; i < physics.tool_count(); ++i) add_tool(i, physics);
  for (const api::Intruder& intruder : intruders) {
    add(intruder.X_WI.isometry(), robot::BoxShape{intruder.size_m});
  }
  add_bodies(physics);
}

void SensorOccluders::add(const Eigen::Isometry3d& X_WS, const sensors::Shape& shape, int body) {
  occluders_.push_back({X_WS, shape, sensors::bounding_radius(shape), body});
}

void SensorOccluders::add_tool(int index, const physics::PhysicsWorld& physics) {
  const physics::BodyState state = physics.tool(index);
  if (state.lost_step) return;
  const Eigen::Isometry3d X_WT = Pose{state.p_WB, state.q_WB}.isometry();
  const auto add_block = [&](const scene::Block& block) {
    add(X_WT * Eigen::Translation3d(block.centre), robot::BoxShape{block.size});
  };
  const scene::Tool& tool = tools_[static_cast<std::size_t>(index)];
  add_block(scene::palm_of(tool.gripper));
  for (const auto& finger : scene::fingers_of(tool.gripper, physics.opening(index))) {
    add_block(finger);
  }
  const scene::Block neck = scene::neck_of(tool);
  if (neck.size.z() > 0) add_block(neck);
}

void SensorOccluders::add_bodies(const physics::PhysicsWorld& physics) {
  for (std::size_t i = 0; i < X_WP_.size(); ++i) {
    const int body = static_cast<int>(i);
    const physics::BodyState state = physics.body(body);
    X_WP_[i] = Pose{state.p_WB, state.q_WB}.isometry();
    if (state.lost_step) {
      X_WP_[i].translation().head<2>().setConstant(kOutOfSight_m);
      continue;
    }
    if (i < trays_.size()) {
      add_tray(*trays_[i], body);
    } else if (i < trays_.size() + gears_.size()) {
      add_gear(*gears_[i - trays_.size()], body);
    } else {
      add_part(*parts_[i - trays_.size() - gears_.size()], body);
    }
  }
}

void SensorOccluders::add_tray(const scene::TrayType& type, int body) {
  const Eigen::AlignedBox3d slab = scene::slab_of(type);
  add(X_WP_[static_cast<std::size_t>(body)] * Eigen::Translation3d(slab.center()),
      sensors::slab_shape(slab, type.outline), body);
}

/// Each piece as the cylinder around it.
void SensorOccluders::add_gear(const scene::GearType& type, int body) {
  const scene::GearShapes gear = scene::shapes_of(type);
  for (const scene::Frustum& piece : {gear.disc, gear.peg, gear.hub}) {
    const Eigen::Translation3d X_GS(0, 0, 0.5 * (piece.z_low + piece.z_high));
    add(X_WP_[static_cast<std::size_t>(body)] * X_GS,
        robot::CylinderShape{std::max(piece.radius_low, piece.radius_high),
                             piece.z_high - piece.z_low},
        body);
  }
}

void SensorOccluders::add_part(const scene::PartType& type, int body) {
  for (const api::Piece& piece : type.pieces) {
    occluders_.push_back(sensors::occluder_of(piece, X_WP_[static_cast<std::size_t>(body)]));
    occluders_.back().body = body;
  }
}

}  // namespace aprsim::world
