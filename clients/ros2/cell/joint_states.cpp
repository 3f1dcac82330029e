#include "clients/ros2/cell/joint_states.hpp"

namespace aprsim::ros2 {

void append_joints(JointStates& states, const v1::RobotState& robot,
                   const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < names.size() && i < static_cast<std::size_t>(robot.joints_size());
       ++i) {
    const auto& joint = robot.joints(static_cast<int>(i));
    states.name.push_back(names[i]);
    states.position.push_back(joint.position_rad());
    states.velocity.push_back(joint.velocity_rad_s());
    states.effort.push_back(joint.torque_nm());
  }
}

}  // namespace aprsim::ros2
