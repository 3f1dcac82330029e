#include "world/robot/kinematics/families/spherical_wrist_ik.hpp"

#include <cmath>
#include <numbers>

#include "world/robot/kinematics/families/euler_angles.hpp"
#include "world/robot/kinematics/families/two_bone.hpp"
#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

constexpr double kOnFirstAxis =
    1e-10;  ///< wrist centre this close to axis 1: its angle is free [m]

}  // namespace

SphericalWristIk::SphericalWristIk(const ArmModel& model, SphericalWristGeometry geometry)
    : BranchedIk(model),
      geometry_(std::move(geometry)),
      fore_(std::hypot(geometry_.fore_x, geometry_.elbow_z)),
      fore_angle_(std::atan2(geometry_.elbow_z, geometry_.fore_x)) {}

/// Kinematic decoupling: Pieper 1968; Siciliano et al. 2009, sec. 2.12. The angles t are those
/// about +z +y +y +x +y +x; q = sign t.
BranchedIk::Branches SphericalWristIk::branches(const Eigen::Isometry3d& X_BF,
                                                const JointVector& seed,
                                                double /*elbow_rad*/) const {
  // Wrist centre, in cylindrical coordinates about axis 1 from the height of axis 2.
  const Eigen::Matrix3d R = X_BF.linear();
  const Eigen::Vector3d wrist = X_BF.translation() - geometry_.flange_x * R.col(0);
  const double z = wrist.z() - geometry_.shoulder_z;
  const double lateral = geometry_.lateral;
  const double from_axis = std::hypot(wrist.x(), wrist.y());
  Branches out;
  if (from_axis < std::abs(lateral) - kReachTolerance) {
    out.excess_m = from_axis - std::abs(lateral);
    out.limit_m = std::abs(lateral);
    return out;
  }
  const double radius = lateral == 0 ? from_axis : leg(from_axis, lateral);
  const JointVector& sign = geometry_.sign;
  for (const double facing : {1.0, -1.0}) {
    // Axis 1 towards the wrist centre or away from it.
    double t1 = sign(0) * seed(0);
    if (lateral != 0) {
      t1 = std::atan2(wrist.y(), wrist.x()) - std::atan2(lateral, facing * radius);
    } else if (radius >= kOnFirstAxis) {
      t1 = std::atan2(facing * wrist.y(), facing * wrist.x());
    }
    // Elbow from the triangle of upper arm, forearm and shoulder-wrist line.
    const double r = facing * radius - geometry_.shoulder_x;
    const TwoBone arm = solve_two_bone(geometry_.upper, fore_, std::hypot(r, z));
    if (arm.excess_m != 0) {
      const bool nearer = out.excess_m == 0 || std::abs(arm.excess_m) < std::abs(out.excess_m);
      if (nearer) {
        out.excess_m = arm.excess_m;
        out.limit_m = arm.limit_m;
      }
      continue;
    }
    for (const double elbow : {1.0, -1.0}) {
      // Elevations in the arm's plane, from outwards towards up; bend turns the forearm up.
      const double bend = elbow * arm.bend_rad;
      const double upper_elevation =
          std::atan2(z, r) -
          std::atan2(fore_ * std::sin(bend), geometry_.upper + fore_ * std::cos(bend));
      // Joint angles are measured from the zero posture: upper arm up, forearm forward.
      const double t2 = std::numbers::pi / 2 - upper_elevation;
      const double t3 = fore_angle_ - std::numbers::pi / 2 - bend;
      // Wrist angles from the rotation that the forearm leaves.
      Eigen::Matrix3d R_forearm = Eigen::Matrix3d::Identity();
      rotate_by(R_forearm, Eigen::Vector3d::UnitZ(), t1);
      rotate_by(R_forearm, Eigen::Vector3d::UnitY(), t2 + t3);
      const Eigen::Matrix3d R_wrist = R_forearm.transpose() * R;
      for (const double flip : {1.0, -1.0}) {
        const EulerAngles t = split_xyx(R_wrist, flip, sign(3) * seed(3));
        JointVector& q = out.q[static_cast<std::size_t>(out.count++)];
        q.resize(6);
        q << t1, t2, t3, t.first, t.middle, t.last;
        q.array() *= sign.array();
      }
    }
  }
  return out;
}

/// Signs of the branch: facing the target, elbow above the shoulder-wrist line, wrist not flipped.
api::Posture SphericalWristIk::posture_of(const JointVector& q) const {
  const JointVector t = q.cwiseProduct(geometry_.sign);
  const double elevation = std::numbers::pi / 2 - t(1);
  const double bend =
      std::remainder(fore_angle_ - std::numbers::pi / 2 - t(2), 2 * std::numbers::pi);
  const double r = geometry_.shoulder_x + geometry_.upper * std::cos(elevation) +
                   fore_ * std::cos(elevation + bend);
  const bool facing = r >= 0;
  // A forearm turned up hangs below the line to the wrist, and above it behind the back.
  const bool above = (bend <= 0) == facing;
  return {facing ? 1 : -1, above ? 1 : -1, t(4) >= 0 ? 1 : -1, 0};
}

}  // namespace aprsim::robot
