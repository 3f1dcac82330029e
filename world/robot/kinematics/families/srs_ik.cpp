#include "world/robot/kinematics/families/srs_ik.hpp"

#include <cmath>
#include <numbers>

#include "world/robot/kinematics/families/euler_angles.hpp"
#include "world/robot/kinematics/families/two_bone.hpp"
#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

constexpr double kUpright = 1e-9;  ///< sine between shoulder-wrist line and vertical

/// Right-handed frame about the shoulder-wrist direction: `up` and `side` span the elbow's circle.
struct ElbowCircle {
  Eigen::Vector3d n, up, side;
};

/// The side is horizontal. As a cross product it is orthogonal to n also close to the vertical.
ElbowCircle elbow_circle(const Eigen::Vector3d& n) {
  Eigen::Vector3d side(n.y(), -n.x(), 0);
  if (side.norm() < kUpright) side = n.z() * Eigen::Vector3d::UnitY();
  side.normalize();
  return {n, side.cross(n).normalized(), side};
}

const Eigen::Vector3d kUnitY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kUnitZ = Eigen::Vector3d::UnitZ();

}  // namespace

SrsIk::SrsIk(const ArmModel& model, SrsGeometry geometry)
    : BranchedIk(model), geometry_(std::move(geometry)) {}

/// Shimizu et al. 2008, with the elbow placed on its circle directly instead of by the
/// rotation of a reference plane. The angles t are those about +z +y +z +y +z +y +z; q = sign t.
BranchedIk::Branches SrsIk::branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                     double elbow_rad) const {
  // Shoulder to wrist centre; its length alone decides the elbow joint.
  const Eigen::Matrix3d R = X_BF.linear();
  const Eigen::Vector3d wrist =
      X_BF.translation() - geometry_.flange_z * R.col(2) - geometry_.shoulder_z * kUnitZ;
  const double distance = wrist.norm();
  const TwoBone arm = solve_two_bone(geometry_.upper, geometry_.fore, distance);
  Branches out{.excess_m = arm.excess_m, .limit_m = arm.limit_m};
  if (arm.excess_m != 0) return out;
  if (distance < kReachTolerance) {  // folded onto the shoulder: no shoulder-wrist line
    out.excess_m = -kReachTolerance;
    out.limit_m = kReachTolerance;
    return out;
  }
  // Upper arm: to the point of the elbow's circle at the elbow angle.
  const ElbowCircle circle = elbow_circle(wrist / distance);
  const Eigen::Vector3d outwards =
      std::cos(elbow_rad) * circle.up + std::sin(elbow_rad) * circle.side;
  const double a = geometry_.upper, b = geometry_.fore;
  // Law of cosines in the triangle of shoulder, elbow and wrist: the angle at the shoulder.
  const double cosine = (a * a + distance * distance - b * b) / (2 * a * distance);
  const double sine = b * std::sin(arm.bend_rad) / distance;
  const Eigen::Vector3d upper_dir = cosine * circle.n + sine * outwards;
  const JointVector& sign = geometry_.sign;
  for (const double bend : {1.0, -1.0}) {
    const double t4 = bend * arm.bend_rad;
    // Frames of upper arm and forearm; shoulder and wrist angles from them.
    // The upper arm's y axis is the elbow's axis. It is orthogonal to the arm's plane, and its sign
    // selects the elbow branch.
    Eigen::Matrix3d R_upper;
    R_upper.col(0) = bend * (sine * circle.n - cosine * outwards);
    R_upper.col(2) = upper_dir;
    R_upper.col(1) = R_upper.col(2).cross(R_upper.col(0));
    Eigen::Matrix3d R_fore = R_upper;
    rotate_by(R_fore, kUnitY, t4);
    const Eigen::Matrix3d R_wrist = R_fore.transpose() * R;
    for (const double shoulder : {1.0, -1.0}) {
      const EulerAngles s = split_zyz(R_upper, shoulder, sign(0) * seed(0));
      for (const double flip : {1.0, -1.0}) {
        const EulerAngles w = split_zyz(R_wrist, flip, sign(4) * seed(4));
        JointVector& q = out.q[static_cast<std::size_t>(out.count++)];
        q.resize(7);
        q << s.first, s.middle, s.last, t4, w.first, w.middle, w.last;
        q.array() *= sign.array();
      }
    }
  }
  return out;
}

/// From the elbow's axis, which is defined also for a stretched arm, whose elbow is on the
/// shoulder-wrist line.
double SrsIk::elbow_of(const JointVector& q) const {
  const JointVector t = q.cwiseProduct(geometry_.sign);
  Eigen::Matrix3d R_upper = Eigen::Matrix3d::Identity();
  rotate_by(R_upper, kUnitZ, t(0));
  rotate_by(R_upper, kUnitY, t(1));
  rotate_by(R_upper, kUnitZ, t(2));
  Eigen::Matrix3d R_fore = R_upper;
  rotate_by(R_fore, kUnitY, t(3));
  const Eigen::Vector3d wrist = geometry_.upper * R_upper.col(2) + geometry_.fore * R_fore.col(2);
  const ElbowCircle circle = elbow_circle(wrist.normalized());
  const double bend = t(3) < 0 ? -1 : 1;
  const Eigen::Vector3d outwards = bend * circle.n.cross(R_upper.col(1));
  return std::atan2(outwards.dot(circle.side), outwards.dot(circle.up));
}

api::Posture SrsIk::posture_of(const JointVector& q) const {
  const JointVector t = q.cwiseProduct(geometry_.sign);
  const auto sign = [](double angle) { return angle >= 0 ? 1 : -1; };
  return {sign(t(1)), sign(t(3)), sign(t(5)), elbow_of(q)};
}

}  // namespace aprsim::robot
