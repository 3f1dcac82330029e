#pragma once

#include <string>
#include <vector>

#include "aprsim/v1/snapshot.pb.h"

namespace aprsim::ros2 {

/// The joints of one or more robots, as sensor_msgs/msg/JointState has them; one value for each
/// name.
struct JointStates {
  std::vector<std::string> name;
  std::vector<double> position;  ///< rad; m of a prismatic joint
  std::vector<double> velocity;  ///< rad/s; m/s
  std::vector<double> effort;    ///< N m; N
};

/// Adds the joints of a robot. `names`: one for each of its joints.
void append_joints(JointStates& states, const v1::RobotState& robot,
                   const std::vector<std::string>& names);

}  // namespace aprsim::ros2
