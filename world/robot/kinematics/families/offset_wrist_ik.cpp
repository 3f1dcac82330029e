#include "world/robot/kinematics/families/offset_wrist_ik.hpp"

#include <cmath>
#include <numbers>

#include "world/robot/kinematics/families/euler_angles.hpp"
#include "world/robot/kinematics/families/two_bone.hpp"
#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

const Eigen::Vector3d kAxisY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kAxisZ = Eigen::Vector3d::UnitZ();

/// Near the singular middle angle rounding of R moves the first one by far more: within that the
/// seed's angle is as good, and a stretched arm stays within reach.
EulerAngles wrist_angles(const Eigen::Matrix3d& R, double flip, double seed) {
  constexpr double kRounding = 2e-15;
  EulerAngles w = split_yzy(R, flip, seed);
  const double apart = std::remainder(w.first - seed, 2 * std::numbers::pi);
  if (apart == 0 || std::abs(apart * std::sin(w.middle)) > kRounding) return w;
  w.first = seed;
  Eigen::Matrix3d rest = Eigen::Matrix3d::Identity();
  rotate_by(rest, kAxisZ, -w.middle);
  rotate_by(rest, kAxisY, -w.first);
  rest = (rest * R).eval();
  w.last = std::atan2(rest(0, 2), rest(0, 0));
  return w;
}

}  // namespace

OffsetWristIk::OffsetWristIk(const ArmModel& model, const OffsetWristGeometry& geometry)
    : BranchedIk(model), geometry_(geometry) {}

/// Hawkins 2013: rotation of axis 1 from the wrist centre's distance from the arm's plane.
BranchedIk::Branches OffsetWristIk::branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                             double /*elbow_rad*/) const {
  Branches out;
  const Eigen::Vector3d wrist = X_BF.translation();
  const double from_axis = std::hypot(wrist.x(), wrist.y());
  const double lateral = geometry_.lateral;
  if (from_axis < std::abs(lateral) - kReachTolerance) {
    out.excess_m = from_axis - std::abs(lateral);
    out.limit_m = std::abs(lateral);
    return out;
  }
  const double radius = leg(from_axis, lateral);
  for (const double facing : {1.0, -1.0}) {
    // A wrist centre on axis 1 leaves its angle free.
    const double t1 = from_axis < kReachTolerance
                          ? seed(0)
                          : std::atan2(wrist.y(), wrist.x()) - std::atan2(lateral, facing * radius);
    Eigen::Matrix3d R_back = Eigen::Matrix3d::Identity();
    rotate_by(R_back, kAxisZ, -t1);
    add_elbows(t1, R_back * X_BF.linear(), R_back * wrist, seed, out);
  }
  return out;
}

/// The branches of one angle of axis 1; pose of the flange in axes turned with it.
void OffsetWristIk::add_elbows(double t1, const Eigen::Matrix3d& R, const Eigen::Vector3d& wrist,
                               const JointVector& seed, Branches& out) const {
  for (const double flip : {1.0, -1.0}) {
    // The sum of the three parallel angles, and the wrist's last two.
    const EulerAngles w = wrist_angles(R, flip, seed(1) + seed(2) + seed(3));
    // From the wrist centre back along axis 5 to axis 4, in the arm's plane.
    const double x = wrist.x() - std::sin(w.first) * geometry_.wrist_z - geometry_.shoulder_x;
    const double z = wrist.z() - std::cos(w.first) * geometry_.wrist_z;
    const TwoBone arm = solve_two_bone(geometry_.upper, geometry_.fore, std::hypot(x, z));
    if (arm.excess_m != 0) {
      if (out.excess_m == 0 || std::abs(arm.excess_m) < std::abs(out.excess_m)) {
        out.excess_m = arm.excess_m;
        out.limit_m = arm.limit_m;
      }
      continue;
    }
    for (const double elbow : {1.0, -1.0}) {
      const double t3 = elbow * arm.bend_rad;
      const double t2 =
          std::atan2(x, z) - std::atan2(geometry_.fore * std::sin(t3),
                                        geometry_.upper + geometry_.fore * std::cos(t3));
      JointVector& q = out.q[static_cast<std::size_t>(out.count++)];
      q.resize(6);
      q << t1, t2, t3, w.first - t2 - t3, w.middle, w.last;
    }
  }
}

/// Signs of the branch: facing the target, elbow above the line from shoulder to wrist, axis 5.
api::Posture OffsetWristIk::posture_of(const JointVector& q) const {
  const double radius = geometry_.shoulder_x + geometry_.upper * std::sin(q(1)) +
                        geometry_.fore * std::sin(q(1) + q(2)) +
                        geometry_.wrist_z * std::sin(q(1) + q(2) + q(3));
  const bool facing = radius >= 0;
  // A positive angle of axis 3 turns the forearm down in front of the arm.
  const bool above = (std::sin(q(2)) >= 0) == facing;
  return {facing ? 1 : -1, above ? 1 : -1, std::sin(q(4)) >= 0 ? 1 : -1, 0};
}

}  // namespace aprsim::robot
