#pragma once

#include <span>
#include <vector>

#include "world/api/values/light_curtain.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/physics/physics_world.hpp"
#include "world/scene/model/scene.hpp"
#include "world/sensors/line_of_sight.hpp"

namespace aprsim::world {

/// The solids that optical sensors detect or that occlude them, at one instant: collision shapes of
/// all links, tools, trays, gears, parts and intruders. Fixed bodies are left out: a scene places
/// its sensors clear of them. Thread: sim.
class SensorOccluders {
 public:
  /// `scene` and `models` must outlive this.
  SensorOccluders(const scene::Scene& scene, std::span<const robot::ArmModel> models);

  /// Updates all from the present state. Does not allocate, unless there are many intruders.
  void gather(std::span<const SimulatedRobot> robots, const physics::PhysicsWorld& physics,
              std::span<const api::Intruder> intruders);

  [[nodiscard]] std::span<const sensors::Occluder> all() const { return occluders_; }
  /// Poses of the free bodies, as numbered in the cell; lost ones are out of sight.
  [[nodiscard]] std::span<const Eigen::Isometry3d> X_WP() const { return X_WP_; }

 private:
  void add(const Eigen::Isometry3d& X_WS, const sensors::Shape& shape, int body = -1);
  void add_tool(int index, const physics::PhysicsWorld& physics);
  void add_tray(const scene::TrayType& type, int body);
  void add_gear(const scene::GearType& type, int body);
  void add_part(const scene::PartType& type, int body);
  void add_bodies(const physics::PhysicsWorld& physics);

  std::span<const robot::ArmModel> models_;
  std::vector<scene::Tool> tools_;
  std::vector<const scene::TrayType*> trays_;
  std::vector<const scene::GearType*> gears_;
  std::vector<const scene::PartType*> parts_;
  std::vector<Eigen::Isometry3d> X_WP_;
  std::vector<sensors::Occluder> occluders_;
};

}  // namespace aprsim::world
