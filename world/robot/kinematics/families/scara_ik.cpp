#include "world/robot/kinematics/families/scara_ik.hpp"

#include <cmath>

#include "world/robot/kinematics/families/two_bone.hpp"

namespace aprsim::robot {

ScaraIk::ScaraIk(const ArmModel& model, const ScaraGeometry& geometry)
    : BranchedIk(model), geometry_(geometry) {}

/// Law of cosines in the plane (Siciliano et al. 2009, sec. 2.12.1); height and rotation are left
/// to one joint each.
BranchedIk::Branches ScaraIk::branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                       double /*elbow_rad*/) const {
  Branches out;
  const Eigen::Matrix3d R = X_BF.linear();
  const double tilt = std::atan2(std::hypot(R(0, 2), R(1, 2)), R(2, 2));
  if (tilt > kTiltTolerance_rad) {
    out.tilt_rad = tilt;
    return out;
  }
  const Eigen::Vector3d p = X_BF.translation();
  const double distance = std::hypot(p.x(), p.y());
  const TwoBone arm = solve_two_bone(geometry_.upper, geometry_.fore, distance);
  if (arm.excess_m != 0) {
    out.excess_m = arm.excess_m;
    out.limit_m = arm.limit_m;
    return out;
  }
  const auto [first, second, third] = geometry_.turning;
  const double yaw = std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
  for (const double elbow : {1.0, -1.0}) {
    const double t2 = elbow * arm.bend_rad;
    // A flange on the first axis leaves the direction free.
    const double t1 = distance < kReachTolerance
                          ? seed(first)
                          : std::atan2(p.y(), p.x()) -
                                std::atan2(geometry_.fore * std::sin(t2),
                                           geometry_.upper + geometry_.fore * std::cos(t2));
    JointVector& q = out.q[static_cast<std::size_t>(out.count++)];
    q.resize(4);
    q(first) = t1;
    q(second) = t2;
    q(third) = yaw - t1 - t2;
    q(geometry_.sliding) = p.z();
  }
  return out;
}

/// Only the elbow has two sides: +1 where it bends to the left.
api::Posture ScaraIk::posture_of(const JointVector& q) const {
  return {1, std::sin(q(geometry_.turning[1])) >= 0 ? 1 : -1, 1, 0};
}

}  // namespace aprsim::robot
