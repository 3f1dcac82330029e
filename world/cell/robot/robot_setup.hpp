#pragma once

#include <memory>

#include "world/cell/robot/flange_tools.hpp"
#include "world/robot/controller/controller_setup.hpp"
#include "world/robot/kinematics/inverse_kinematics.hpp"
#include "world/scene/model/scene.hpp"

/// Constants of a robot's arm and controller, from the scene.
namespace aprsim::world {

/// Home posture. Throws std::runtime_error when it is not one value a joint.
[[nodiscard]] robot::JointVector home_of(const scene::Robot& robot, const robot::ArmModel& model);

/// Gravitational acceleration in the arm's base [m/s^2].
[[nodiscard]] Eigen::Vector3d gravity_in_base(const scene::Robot& robot,
                                              const scene::Physics& physics);

/// Throws std::runtime_error when no solver takes the model.
[[nodiscard]] std::shared_ptr<const robot::InverseKinematics> inverse_kinematics_of(
    const scene::Robot& robot, const robot::ArmModel& model);

/// Helpers of a controller's planning, each may be null, and the robot's index.
struct PlanningHelp {
  robot::PlanPrefetcher* prefetcher = nullptr;
  const robot::SurroundingsSource* surroundings = nullptr;
  std::size_t index = 0;
};

/// `tool`: on the flange at the start, -1 = none.
[[nodiscard]] robot::ControllerSetup controller_setup_of(
    const scene::Robot& robot, const robot::ArmModel& model,
    std::shared_ptr<const robot::InverseKinematics> ik, const scene::Physics& physics,
    const FlangeTools& tools, int tool, const PlanningHelp& help);

}  // namespace aprsim::world
