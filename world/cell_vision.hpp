#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "world/physics/physics_world.hpp"
#include "world/robot_cell.hpp"
#include "world/scene/scene.hpp"
#include "world/sensors/vision_feed.hpp"

namespace aprsim::world {

/// The cameras of the cell, one for each robot, and what stands in their way: the links of all arms
/// and their grippers. Thread: sim.
class CellVision {
 public:
  /// `models` must outlive this.
  CellVision(const scene::Scene& scene, std::span<const robot::ArmModel> models, SimTime step_size,
             std::uint64_t seed, std::size_t body_count);

  /// Once a step, with the state at its end; also once before the first, with step 0.
  void look(std::uint64_t step, const api::CellDescription& cell, std::span<const RobotCell> robots,
            const physics::PhysicsWorld& physics);

  [[nodiscard]] const api::VisionFrame& latest(std::size_t robot) const {
    return feeds_[robot].latest();
  }

 private:
  void gather(std::span<const RobotCell> robots, const physics::PhysicsWorld& physics);
  void add(const Eigen::Isometry3d& X_WS, const sensors::Shape& shape);
  void add_gripper(const scene::Gripper& gripper, const physics::GripperState& state);

  const scene::Scene& scene_;
  std::span<const robot::ArmModel> models_;
  std::vector<sensors::VisionFeed> feeds_;
  std::vector<sensors::Occluder> occluders_;
  std::vector<Eigen::Isometry3d> X_WP_;
};

}  // namespace aprsim::world
