#include "world/robot/controller/controller_setup.hpp"

#include <stdexcept>

namespace aprsim::robot {

ControllerSetup checked(ControllerSetup setup) {
  if (!setup.ik) throw std::invalid_argument("robot controller: no inverse kinematics");
  if (!(setup.step_s > 0)) throw std::invalid_argument("robot controller: step must be > 0");
  if (setup.q_home.size() != setup.model.dof()) {
    throw std::invalid_argument("robot controller: home needs one value a joint");
  }
  for (int i = 0; i < setup.model.dof(); ++i) {
    const Joint& joint = setup.model.joints[static_cast<std::size_t>(i)];
    if (!(setup.q_home(i) >= joint.lower_rad && setup.q_home(i) <= joint.upper_rad)) {
      throw std::invalid_argument("robot controller: home of " + joint.name +
                                  " is outside its limits");
    }
  }
  // A robot without a tool changer has one fixed tool.
  if (setup.tools.empty()) setup.tools.push_back({setup.X_FT, setup.payload});
  return setup;
}

std::vector<EquippedArm> equipped_arms(const ControllerSetup& setup) {
  std::vector<EquippedArm> arms;
  const auto add = [&](const Eigen::Isometry3d& X_FT, const Payload& payload) {
    arms.push_back(
        {MotionPlanner(PlannerSetup{setup.model, setup.ik, setup.X_BR, payload, setup.gravity_B}),
         X_FT, setup.step_s});
  };
  // Each tool has its own payload and so its own joint limits. Planners for all of them are made
  // once.
  for (const ToolSetup& tool : setup.tools) add(tool.X_FT, tool.payload);
  add(setup.X_FT_open, setup.payload_open);
  return arms;
}

ToolLimits tool_maximum(const ControllerSetup& setup) {
  return {setup.max_trans_speed_m_s, setup.max_trans_accel_m_s2, setup.max_rot_speed_rad_s,
          setup.max_rot_accel_rad_s2};
}

}  // namespace aprsim::robot
