#pragma once

#include <Eigen/Core>

namespace aprsim::scene {

/// Errors of the force sensor between flange and tool, along the axes of the tool. SI.
struct ForceSensor {
  Eigen::Vector3d bias_n = Eigen::Vector3d::Zero();     ///< reading without load at time zero
  Eigen::Vector3d drift_n_s = Eigen::Vector3d::Zero();  ///< change of the bias in a second
  double noise_n = 0;                                   ///< standard deviation along each axis
};

}  // namespace aprsim::scene
