#include "world/sensor_occluders.hpp"

#include <algorithm>
#include <cstddef>

#include "world/scene/part_shapes.hpp"

namespace aprsim::world {
namespace {

constexpr std::size_t kGripperOccluders = 3, kGearOccluders = 3;
constexpr double kOutOfSight_m = 1e6;  // to the side of every camera's area

}  // namespace

SensorOccluders::SensorOccluders(const scene::Scene& scene, std::span<const robot::ArmModel> models)
    : scene_(scene), models_(models) {
  for (const auto& tray : scene.trays) trays_.push_back(&scene.tray_types.at(tray.type));
  for (const auto& gear : scene.gears) gears_.push_back(&scene.gear_types.at(gear.type));
  X_WP_.resize(trays_.size() + gears_.size());
  std::size_t count = trays_.size() + kGearOccluders * gears_.size() + 1;
  for (const auto& model : models) {
    for (const auto& link : model.links) count += link.collision.size();
    count += kGripperOccluders;
  }
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
        add(X_WL[link] * part.X_LS, part.shape);
      }
    }
    add_gripper(scene_.robots[i].gripper, physics.gripper(static_cast<int>(i)));
  }
  for (const api::Intruder& intruder : intruders) {
    add(intruder.X_WI.isometry(), robot::BoxShape{intruder.size_m});
  }
  add_bodies(physics);
}

void SensorOccluders::add(const Eigen::Isometry3d& X_WS, const sensors::Shape& shape, int body) {
  occluders_.push_back({X_WS, shape, sensors::bounding_radius(shape), body});
}

void SensorOccluders::add_gripper(const scene::Gripper& gripper,
                                  const physics::GripperState& state) {
  const Eigen::Isometry3d X_WT = state.X_WT.isometry();
  const auto add_block = [&](const scene::Block& block) {
    add(X_WT * Eigen::Translation3d(block.centre), robot::BoxShape{block.size});
  };
  add_block(scene::palm_of(gripper));
  for (const auto& finger : scene::fingers_of(gripper, state.separation_m)) add_block(finger);
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
    } else {
      add_gear(*gears_[i - trays_.size()], body);
    }
  }
}

void SensorOccluders::add_tray(const scene::TrayType& type, int body) {
  const Eigen::AlignedBox3d slab = scene::slab_of(type);
  add(X_WP_[static_cast<std::size_t>(body)] * Eigen::Translation3d(slab.center()),
      robot::BoxShape{slab.sizes()}, body);
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

}  // namespace aprsim::world
