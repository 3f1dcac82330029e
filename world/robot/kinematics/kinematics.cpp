#include "world/robot/kinematics/kinematics.hpp"

#include <cassert>
#include <cstddef>

#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

/// Steps from a link to the next one outwards.
void advance(Eigen::Isometry3d& X_BL, const Joint& joint, double q) {
  X_BL.translation() += X_BL.linear() * joint.X_PJ.translation();
  Eigen::Matrix3d R_BL = X_BL.linear() * joint.X_PJ.linear();
  rotate_by(R_BL, joint.axis, q);
  X_BL.linear() = R_BL;
}

}  // namespace

/// Product of the joint transforms from the base outwards.
void link_poses(const ArmModel& model, const JointVector& q, std::span<Eigen::Isometry3d> X_BL) {
  assert(q.size() == model.dof() && X_BL.size() == model.links.size());
  X_BL[0].setIdentity();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    X_BL[i + 1] = X_BL[i];
    advance(X_BL[i + 1], model.joints[i], q(static_cast<Eigen::Index>(i)));
  }
}

Eigen::Isometry3d flange_pose(const ArmModel& model, const JointVector& q) {
  assert(q.size() == model.dof());
  Eigen::Isometry3d X_BL = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    advance(X_BL, model.joints[i], q(static_cast<Eigen::Index>(i)));
  }
  return X_BL;
}

/// Geometric Jacobian of revolute joints: columns z x (p - o) and z (Siciliano et al. 2009,
/// sec. 3.1).
Jacobian point_jacobian(const ArmModel& model, const JointVector& q, int link,
                        const Eigen::Vector3d& p_L) {
  assert(q.size() == model.dof() && link >= 0 && link <= model.dof());
  Jacobian J = Jacobian::Zero(6, model.dof());
  Eigen::Isometry3d X_BL = Eigen::Isometry3d::Identity();
  for (int i = 0; i < link; ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    advance(X_BL, joint, q(i));
    // The axis is invariant under the joint's own rotation. The upper rows hold the joint's origin
    // until the point is known.
    J.block<3, 1>(3, i) = X_BL.linear() * joint.axis;
    J.block<3, 1>(0, i) = X_BL.translation();
  }
  const Eigen::Vector3d p_B = X_BL * p_L;
  for (int i = 0; i < link; ++i) {
    const Eigen::Vector3d axis = J.block<3, 1>(3, i);
    const Eigen::Vector3d lever = p_B - J.block<3, 1>(0, i);
    J.block<3, 1>(0, i) = axis.cross(lever);
  }
  return J;
}

}  // namespace aprsim::robot
