#pragma once

#include <Eigen/Geometry>

namespace aprsim {

/// Rigid pose X_AB of frame B in frame A: position of B's origin [m] and rotation.
struct Pose {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();

  static Pose from(const Eigen::Isometry3d& X) {
    return {X.translation(), Eigen::Quaterniond(X.linear())};
  }
  [[nodiscard]] Eigen::Isometry3d isometry() const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = q.toRotationMatrix();
    X.translation() = p;
    return X;
  }
};

}  // namespace aprsim
