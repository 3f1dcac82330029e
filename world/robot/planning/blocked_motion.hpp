#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// The motion of a move that was refused because it would touch something.
struct BlockedMotion {
  std::string mover, other;                       ///< the part of the robot, and what it touches
  Eigen::Vector3d p_R = Eigen::Vector3d::Zero();  ///< middle of the mover's shape there [m]
  double time_s = 0;                              ///< of the touch, after the motion's start
  double interval_s = 0;                          ///< between two postures
  std::vector<JointVector> postures;              ///< from the start to the end
};

}  // namespace aprsim::robot
