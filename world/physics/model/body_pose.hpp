#pragma once

#include <Eigen/Geometry>

namespace aprsim::physics {

/// Pose that a free body is to have.
struct BodyPose {
  int body = 0;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
};

}  // namespace aprsim::physics
