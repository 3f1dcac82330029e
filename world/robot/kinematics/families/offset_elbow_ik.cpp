#include "world/robot/kinematics/families/offset_elbow_ik.hpp"

#include <cmath>
#include <numbers>

#include "world/robot/kinematics/families/euler_angles.hpp"
#include "world/robot/kinematics/families/two_bone.hpp"
#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

const Eigen::Vector3d kPitch = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kRoll = Eigen::Vector3d::UnitZ();

}  // namespace

OffsetElbowIk::OffsetElbowIk(const ArmModel& model, const OffsetElbowGeometry& geometry)
    : BranchedIk(model),
      geometry_(geometry),
      upper_(std::hypot(geometry.elbow_x, geometry.upper)),
      fore_(std::hypot(geometry.fore_x, geometry.fore)),
      upper_angle_(std::atan2(geometry.elbow_x, geometry.upper)),
      fore_angle_(std::atan2(geometry.fore_x, geometry.fore)) {}

/// Shoulder to wrist, in axes of the forearm.
Eigen::Vector3d OffsetElbowIk::wrist_in_fore(double t4) const {
  return {std::sin(upper_angle_ - t4) * upper_ + geometry_.fore_x, 0,
          std::cos(upper_angle_ - t4) * upper_ + geometry_.fore};
}

/// He & Liu 2021: with the last joint's angle given, the wrist's place is known, its distance from
/// the shoulder decides joint 4, and its direction in the flange joints 5 and 6.
BranchedIk::Branches OffsetElbowIk::branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                             double elbow_rad) const {
  Branches out;
  Eigen::Matrix3d R_6 = X_BF.linear();
  rotate_by(R_6, kRoll, -elbow_rad);
  const Eigen::Vector3d wrist = X_BF.translation() - geometry_.wrist_x * R_6.col(0);
  const TwoBone arm = solve_two_bone(upper_, fore_, wrist.norm());
  out.excess_m = arm.excess_m;
  out.limit_m = arm.limit_m;
  if (arm.excess_m != 0) return out;
  for (const double side : {1.0, -1.0}) {
    add_wrists(R_6, wrist, upper_angle_ - fore_angle_ + side * arm.bend_rad, seed, elbow_rad, out);
  }
  return out;
}

/// The branches of one angle of joint 4.
void OffsetElbowIk::add_wrists(const Eigen::Matrix3d& R_6, const Eigen::Vector3d& wrist, double t4,
                               const JointVector& seed, double elbow_rad, Branches& out) const {
  const Eigen::Vector3d v_4 = wrist_in_fore(t4);
  const Eigen::Vector3d v_6 = R_6.transpose() * wrist;
  // v_6 = Ry(-t6) Rz(-t5) v_4: its y is -sin(t5) v_4.x.
  const double across = std::abs(v_4.x());
  if (std::abs(v_6.y()) > across + kReachTolerance) {
    if (out.count == 0) {
      out.excess_m = std::abs(v_6.y()) - across;
      out.limit_m = wrist.norm();
    }
    return;
  }
  const bool free = across < kReachTolerance;
  for (const double flip : {1.0, -1.0}) {
    const double t5 =
        free ? seed(4) : std::atan2(-v_6.y() / v_4.x(), flip * leg(across, v_6.y()) / across);
    const double t6 = std::atan2(v_4.x() * std::cos(t5), v_4.z()) - std::atan2(v_6.x(), v_6.z());
    Eigen::Matrix3d R_3 = R_6;
    rotate_by(R_3, kPitch, -t6);
    rotate_by(R_3, kRoll, -t5);
    rotate_by(R_3, kPitch, -t4);
    for (const double shoulder : {1.0, -1.0}) {
      const EulerAngles s = split_zyz(R_3, shoulder, seed(0));
      JointVector& q = out.q[static_cast<std::size_t>(out.count++)];
      q.resize(7);
      q << s.first, s.middle, s.last, t4, t5, t6, elbow_rad;
    }
    if (free) break;
  }
}

double OffsetElbowIk::elbow_of(const JointVector& q) const {
  return std::remainder(q(6), 2 * std::numbers::pi);
}

api::Posture OffsetElbowIk::posture_of(const JointVector& q) const {
  const auto sign = [](double value) { return value >= 0 ? 1 : -1; };
  return {sign(std::sin(q(1))), sign(std::sin(q(3) + fore_angle_ - upper_angle_)),
          sign(std::cos(q(4))), elbow_of(q)};
}

}  // namespace aprsim::robot
