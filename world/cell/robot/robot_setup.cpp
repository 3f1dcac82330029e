#include "world/cell/robot/robot_setup.hpp"

#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"

namespace aprsim::world {
namespace {

/// From a move's command to its motion: an interpolation cycle of an ordinary robot controller, and
/// what long or searched paths take more.
constexpr robot::PlanningLatency kPlanningLatency{.base_s = 8e-3,
                                                  .waypoint_s = 1e-3,
                                                  .screw_s = 40e-3,
                                                  .search_s = 0.25,
                                                  .check_s = 12e-3,
                                                  .avoid_s = 0.1};

}  // namespace

robot::JointVector home_of(const scene::Robot& robot, const robot::ArmModel& model) {
  if (static_cast<int>(robot.home_rad.size()) != model.dof()) {
    throw std::runtime_error("robot " + robot.name + ": home has " +
                             std::to_string(robot.home_rad.size()) + " values, the model " +
                             std::to_string(model.dof()) + " joints");
  }
  robot::JointVector home = Eigen::Map<const Eigen::VectorXd>(robot.home_rad.data(), model.dof());
  // The scene counts prismatic joints in millimetres, where others have degrees.
  constexpr double kMetresPerRadian = 180 / std::numbers::pi / 1000;
  for (int i = 0; i < model.dof(); ++i) {
    if (model.joints[static_cast<std::size_t>(i)].prismatic) home(i) *= kMetresPerRadian;
  }
  return home;
}

Eigen::Vector3d gravity_in_base(const scene::Robot& robot, const scene::Physics& physics) {
  return robot.X_WB.q.inverse() * Eigen::Vector3d(0, 0, -physics.gravity_m_s2);
}

std::shared_ptr<const robot::InverseKinematics> inverse_kinematics_of(
    const scene::Robot& robot, const robot::ArmModel& model) {
  auto ik = robot::make_inverse_kinematics(model);
  if (!ik) throw std::runtime_error("robot " + robot.name + ": " + ik.error().message);
  return std::move(*ik);
}

robot::ControllerSetup controller_setup_of(const scene::Robot& robot, const robot::ArmModel& model,
                                           std::shared_ptr<const robot::InverseKinematics> ik,
                                           const scene::Physics& physics, const FlangeTools& tools,
                                           int tool, const PlanningHelp& help) {
  return {.model = model,
          .ik = std::move(ik),
          .X_BR = robot.X_BR.isometry(),
          .X_FT_open = robot.tool_point_F.value_or(Pose{}).isometry(),
          .q_home = home_of(robot, model),
          .step_s = physics.step_s,
          .max_trans_speed_m_s = robot.max_trans_speed_m_s,
          .max_trans_accel_m_s2 = robot.max_trans_accel_m_s2,
          .max_rot_speed_rad_s = robot.max_rot_speed_rad_s,
          .max_rot_accel_rad_s2 = robot.max_rot_accel_rad_s2,
          .payload_open = tools.payload(-1),
          .tools = tools.setups(),
          .tool = tool,
          .tool_change_s = robot.changer.time_s,
          .gravity_B = gravity_in_base(robot, physics),
          .latency = kPlanningLatency,
          .prefetcher = help.prefetcher,
          .planning = robot.planning,
          .surroundings = help.surroundings,
          .index = static_cast<int>(help.index)};
}

}  // namespace aprsim::world
