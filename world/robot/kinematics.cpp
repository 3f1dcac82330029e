#include "world/robot/kinematics.hpp"

#include <cassert>
#include <cstddef>

namespace aprsim::robot {
namespace {

/// Pose of the link behind joint i in its parent.
Eigen::Isometry3d joint_pose(const Joint& joint, double q) {
  Eigen::Isometry3d X_PL;
  X_PL.linear() = joint.X_PJ.linear() * Eigen::AngleAxisd(q, joint.axis).toRotationMatrix();
  X_PL.translation() = joint.X_PJ.translation();
  X_PL.makeAffine();
  return X_PL;
}

}  // namespace

void link_poses(const ArmModel& model, const JointVector& q, std::span<Eigen::Isometry3d> X_BL) {
  assert(q.size() == model.dof() && X_BL.size() == model.links.size());
  X_BL[0].setIdentity();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    X_BL[i + 1] = X_BL[i] * joint_pose(model.joints[i], q(static_cast<Eigen::Index>(i)));
  }
}

Eigen::Isometry3d flange_pose(const ArmModel& model, const JointVector& q) {
  assert(q.size() == model.dof());
  Eigen::Isometry3d X_BL = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    X_BL = X_BL * joint_pose(model.joints[i], q(static_cast<Eigen::Index>(i)));
  }
  return X_BL;
}

Jacobian point_jacobian(const ArmModel& model, const JointVector& q, int link,
                        const Eigen::Vector3d& p_L) {
  assert(q.size() == model.dof() && link >= 0 && link <= model.dof());
  Jacobian J = Jacobian::Zero(6, model.dof());
  Eigen::Isometry3d X_BL = Eigen::Isometry3d::Identity();
  for (int i = 0; i < link; ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    X_BL = X_BL * joint_pose(joint, q(i));
    // The axis is the same seen from the link; the origin waits until the point is known.
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
