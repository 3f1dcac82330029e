#include "world/cell_vision.hpp"

#include <algorithm>

#include "world/sensors/random.hpp"

namespace aprsim::world {

CellVision::CellVision(const scene::Scene& scene, std::span<const robot::ArmModel> models,
                       SimTime step_size, std::uint64_t seed, std::size_t body_count)
    : scene_(scene), models_(models), X_WP_(body_count) {
  constexpr std::size_t kGripperShapes = 3;
  std::size_t shapes = 0;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const scene::Robot& robot = scene.robots[i];
    feeds_.emplace_back(robot.vision, robot.X_WB.isometry() * robot.X_BR.isometry(), step_size,
                        sensors::mix_seed(seed, i), body_count);
    for (const auto& link : models[i].links) shapes += link.collision.size();
    shapes += kGripperShapes;
  }
  occluders_.reserve(shapes);
}

void CellVision::look(std::uint64_t step, const api::CellDescription& cell,
                      std::span<const RobotCell> robots, const physics::PhysicsWorld& physics) {
  bool gathered = false;
  for (auto& feed : feeds_) {
    if (feed.due(step)) {
      if (!gathered) gather(robots, physics);
      gathered = true;
      feed.expose(step, cell, X_WP_, occluders_);
    }
    feed.advance(step);
  }
}

void CellVision::gather(std::span<const RobotCell> robots, const physics::PhysicsWorld& physics) {
  for (std::size_t i = 0; i < X_WP_.size(); ++i) {
    const physics::BodyState state = physics.body(static_cast<int>(i));
    X_WP_[i] = Pose{state.p_WB, state.q_WB}.isometry();
  }
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
}

void CellVision::add(const Eigen::Isometry3d& X_WS, const sensors::Shape& shape) {
  occluders_.push_back({X_WS, shape, sensors::bounding_radius(shape)});
}

// The palm behind the pads, and a finger on each side of the gap.
void CellVision::add_gripper(const scene::Gripper& gripper, const physics::GripperState& state) {
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

}  // namespace aprsim::world
