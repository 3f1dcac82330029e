#include "world/sensor_occluders.hpp"

#include <cstddef>

namespace aprsim::world {
namespace {

constexpr std::size_t kGripperSolids = 3, kGearSolids = 3;

}  // namespace

SensorOccluders::SensorOccluders(const scene::Scene& scene, std::span<const robot::ArmModel> models)
    : scene_(scene), models_(models) {
  for (const auto& tray : scene.trays) trays_.push_back(&scene.tray_types.at(tray.type));
  for (const auto& gear : scene.gears) gears_.push_back(&scene.gear_types.at(gear.type));
  X_WP_.resize(trays_.size() + gears_.size());
  std::size_t count = trays_.size() + kGearSolids * gears_.size() + 1;
  for (const auto& model : models) {
    for (const auto& link : model.links) count += link.collision.size();
    count += kGripperSolids;
  }
  solids_.reserve(count);
}

void SensorOccluders::gather(std::span<const SimulatedRobot> robots,
                             const physics::PhysicsWorld& physics,
                             const std::optional<api::Intruder>& intruder) {
  solids_.clear();
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const auto X_WL = robots[i].X_WL();
    for (std::size_t link = 0; link < X_WL.size(); ++link) {
      for (const auto& part : models_[i].links[link].collision) {
        add(X_WL[link] * part.X_LS, part.shape);
      }
    }
    add_gripper(scene_.robots[i].gripper, physics.gripper(static_cast<int>(i)));
  }
  if (intruder) add(intruder->X_WI.isometry(), robot::BoxShape{intruder->size_m});
  add_bodies(physics);
}

void SensorOccluders::add(const Eigen::Isometry3d& X_WS, const sensors::Shape& shape, int body) {
  solids_.push_back({X_WS, shape, sensors::bounding_radius(shape), body});
}

// The palm behind the pads, and a finger on each side of the gap.
void SensorOccluders::add_gripper(const scene::Gripper& gripper,
                                  const physics::GripperState& state) {
  const Eigen::Isometry3d X_WT = state.X_WT.isometry();
  const auto at = [&](double y, double z) {
    return Eigen::Isometry3d(X_WT * Eigen::Translation3d(0, y, z));
  };
  const double palm_z = -gripper.pad_height_m - 0.5 * gripper.palm_size.z();
  add(at(0, palm_z), robot::BoxShape{gripper.palm_size});
  const robot::BoxShape finger{{gripper.pad_width_m, gripper.pad_depth_m, gripper.pad_height_m}};
  const double y = 0.5 * (state.separation_m + gripper.pad_depth_m);
  for (const double side : {-y, y}) add(at(side, -0.5 * gripper.pad_height_m), finger);
}

void SensorOccluders::add_bodies(const physics::PhysicsWorld& physics) {
  for (std::size_t i = 0; i < X_WP_.size(); ++i) {
    const int body = static_cast<int>(i);
    const physics::BodyState state = physics.body(body);
    X_WP_[i] = Pose{state.p_WB, state.q_WB}.isometry();
    if (i < trays_.size()) {
      add_tray(*trays_[i], body);
    } else {
      add_gear(*gears_[i - trays_.size()], body);
    }
  }
}

/// The slab without its pockets.
void SensorOccluders::add_tray(const scene::TrayType& type, int body) {
  const Eigen::Vector2d middle = 0.5 * (type.min_xy + type.max_xy);
  const Eigen::Vector2d size = type.max_xy - type.min_xy;
  const Eigen::Translation3d X_PS(middle.x(), middle.y(), -0.5 * type.thickness_m);
  add(X_WP_[static_cast<std::size_t>(body)] * X_PS,
      robot::BoxShape{{size.x(), size.y(), type.thickness_m}}, body);
}

/// Disc, peg and hub; the hub by its upper, larger radius.
void SensorOccluders::add_gear(const scene::GearType& type, int body) {
  const auto cylinder = [&](double radius, double low, double high) {
    const Eigen::Translation3d X_GS(0, 0, 0.5 * (low + high));
    add(X_WP_[static_cast<std::size_t>(body)] * X_GS, robot::CylinderShape{radius, high - low},
        body);
  };
  cylinder(type.disc_radius_m, 0, type.disc_height_m);
  cylinder(type.peg_radius_m, type.disc_height_m, type.peg_top_m);
  cylinder(type.hub_top_radius_m, -type.hub_height_m, 0);
}

}  // namespace aprsim::world
