#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/api/values/light_curtain.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/physics/physics_world.hpp"
#include "world/robot/avoidance/surroundings.hpp"
#include "world/scene/model/free_body.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

/// The surroundings of each robot of a cell, for the planning of its moves: fixtures, belt and
/// floor, gears, trays and parts, tools that no robot has, persons, and the other robots with what
/// they carry, where they are and along the way that is left of their motions. Shapes enclose what
/// they stand for: a tray's slab has no pockets. Thread: sim.
class CellSurroundings final : public robot::SurroundingsSource {
 public:
  /// The arguments must outlive it.
  CellSurroundings(const scene::Scene& scene, std::span<const robot::ArmModel> models);

  /// The present state, valid until the next call; set before robots plan. Does not allocate.
  void set_present(std::span<const SimulatedRobot> robots, const physics::PhysicsWorld& physics,
                   std::span<const api::Intruder> intruders);

  [[nodiscard]] std::shared_ptr<const robot::Surroundings> gather(
      int robot, api::PlanningMode mode) const override;
  [[nodiscard]] std::uint64_t motions_of_others(int robot) const override;

 private:
  /// Shapes in a common frame.
  struct Piece {
    robot::ConvexShape shape;
    Eigen::Isometry3d X_PS = Eigen::Isometry3d::Identity();
  };
  struct FixedPiece {
    std::string name;
    robot::ConvexShape shape;
    Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  };
  class Gathering;

  [[nodiscard]] std::vector<Piece> tool_pieces(int tool) const;
  [[nodiscard]] std::vector<std::size_t> carried_bodies(int robot) const;
  [[nodiscard]] Eigen::Isometry3d X_WP(std::size_t body) const;

  const scene::Scene& scene_;
  std::span<const robot::ArmModel> models_;
  std::vector<scene::Tool> tools_;
  std::vector<scene::FreeBody> bodies_;
  std::vector<std::vector<Piece>> body_pieces_;
  std::vector<FixedPiece> fixed_;
  std::vector<Eigen::Isometry3d> X_FQ_;  ///< by robot
  std::span<const SimulatedRobot> robots_;
  const physics::PhysicsWorld* physics_ = nullptr;
  std::span<const api::Intruder> intruders_;
};

}  // namespace aprsim::world
