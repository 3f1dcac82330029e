#pragma once

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// Positions, velocities and accelerations of all joints.
struct JointState {
  JointVector q, qd, qdd;
};

}  // namespace aprsim::robot
