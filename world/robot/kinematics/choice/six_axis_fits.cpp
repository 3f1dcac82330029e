#include "world/robot/kinematics/choice/six_axis_fits.hpp"

#include <cmath>

#include "world/robot/kinematics/choice/axis_lines.hpp"
#include "world/robot/kinematics/families/offset_wrist_ik.hpp"
#include "world/robot/kinematics/families/spherical_wrist_ik.hpp"
#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

using Eigen::Vector3d;

const Vector3d kBaseX = Vector3d::UnitX(), kBaseY = Vector3d::UnitY(), kBaseZ = Vector3d::UnitZ();

/// Shoulder and upper arm, which both families share: axis 1 along z, axes 2 and 3 along y.
struct Shoulder {
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  double x = 0;          ///< axis 1 to axis 2
  double upper = 0;      ///< axis 2 to axis 3
  double upper_rad = 0;  ///< the upper arm at zero, from z towards x
  double sign_3 = 1;     ///< of axis 3
  Vector3d elbow_A;      ///< on axis 3, in the plane through the origin
};

std::optional<Shoulder> shoulder_of(const std::vector<AxisLine>& lines) {
  if (!are_orthogonal(lines[0], lines[1]) || !are_parallel(lines[1], lines[2])) return {};
  Shoulder out;
  // The origin on axis 1 at the height of axis 2.
  const Vector3d z = lines[0].direction, y = lines[1].direction;
  out.X_BA.linear() << y.cross(z), y, z;
  out.X_BA.translation() = lines[0].point + z * z.dot(lines[1].point - lines[0].point);
  const Eigen::Isometry3d X_AB = out.X_BA.inverse();
  out.x = (X_AB * lines[1].point).x();
  out.elbow_A = X_AB * lines[2].point;
  out.elbow_A.y() = 0;
  const Vector3d upper = out.elbow_A - out.x * kBaseX;
  out.upper = upper.norm();
  out.upper_rad = std::atan2(upper.x(), upper.z());
  out.sign_3 = lines[2].direction.dot(y) > 0 ? 1 : -1;
  if (out.upper < kLineTolerance) return {};
  return out;
}

Eigen::Matrix3d turned(const Eigen::Matrix3d& R, const Vector3d& axis, double angle) {
  Eigen::Matrix3d out = R;
  rotate_by(out, axis, angle);
  return out;
}

}  // namespace

std::unique_ptr<InverseKinematics> fit_spherical_wrist(const ArmModel& model) {
  const std::vector<AxisLine> lines = axis_lines(model);
  const auto wrist = meeting_point({lines[3], lines[4], lines[5]});
  const auto arm = shoulder_of(lines);
  if (!arm || !wrist || !are_orthogonal(lines[2], lines[3]) ||
      !are_orthogonal(lines[3], lines[4]) || !are_orthogonal(lines[4], lines[5])) {
    return nullptr;
  }
  const Eigen::Isometry3d X_AB = arm->X_BA.inverse();
  const Vector3d wrist_A = X_AB * *wrist, fore = wrist_A - arm->elbow_A;
  // Axis 4 points from the elbow to the wrist.
  Vector3d w4 = X_AB.linear() * lines[3].direction;
  const double sign_4 = fore.dot(w4) < 0 ? -1 : 1;
  w4 *= sign_4;
  const double fore_rad = std::atan2(-w4.z(), w4.x());
  const Eigen::Matrix3d R_3 = turned(Eigen::Matrix3d::Identity(), kBaseY, fore_rad);
  const Vector3d w5 = R_3.transpose() * X_AB.linear() * lines[4].direction;
  const double zero_4 = std::atan2(w5.z(), w5.y());
  const Eigen::Matrix3d R_4 = turned(R_3, kBaseX, zero_4);
  const Vector3d w6 = R_4.transpose() * X_AB.linear() * lines[5].direction;
  const double zero_5 = std::atan2(-w6.z(), w6.x());

  const SphericalWristGeometry geometry{
      .shoulder_x = arm->x,
      .lateral = std::abs(wrist_A.y()) < kLineTolerance ? 0 : wrist_A.y(),
      .upper = arm->upper,
      .elbow_z = fore.dot(R_3.col(2)),
      .fore_x = fore.dot(w4),
      .sign = JointVector::Ones(6)};
  if (std::hypot(geometry.fore_x, geometry.elbow_z) < kLineTolerance) return nullptr;
  CanonicalArm canonical;
  canonical.add(kBaseZ, Vector3d::Zero(), 1, 0);
  canonical.add(kBaseY, {arm->x, geometry.lateral, 0}, 1, arm->upper_rad);
  canonical.add(kBaseY, {0, 0, arm->upper}, arm->sign_3, fore_rad - arm->upper_rad);
  canonical.add(kBaseX, {geometry.fore_x, 0, geometry.elbow_z}, sign_4, zero_4);
  canonical.add(kBaseY, Vector3d::Zero(), 1, zero_5);
  canonical.add(kBaseX, Vector3d::Zero(), 1, 0);
  auto placement = canonical.match(model, arm->X_BA);
  if (!placement) return nullptr;
  return std::make_unique<PlacedIk>(model, std::move(*placement),
                                    std::make_unique<SphericalWristIk>(model, geometry));
}

std::unique_ptr<InverseKinematics> fit_offset_wrist(const ArmModel& model) {
  const std::vector<AxisLine> lines = axis_lines(model);
  const auto wrist = meeting_point({lines[4], lines[5]});
  const auto arm = shoulder_of(lines);
  if (!arm || !wrist || !are_parallel(lines[2], lines[3]) || !are_orthogonal(lines[3], lines[4]) ||
      !are_orthogonal(lines[4], lines[5])) {
    return nullptr;
  }
  const Eigen::Isometry3d X_AB = arm->X_BA.inverse();
  const Vector3d wrist_A = X_AB * *wrist;
  Vector3d axis_4 = X_AB * lines[3].point;
  axis_4.y() = 0;
  const Vector3d fore = axis_4 - arm->elbow_A;
  const double fore_rad = std::atan2(fore.x(), fore.z());
  const Vector3d w5 = X_AB.linear() * lines[4].direction;
  const double wrist_rad = std::atan2(w5.x(), w5.z());
  const Eigen::Matrix3d R_4 = turned(Eigen::Matrix3d::Identity(), kBaseY, wrist_rad);
  const Vector3d w6 = R_4.transpose() * X_AB.linear() * lines[5].direction;
  const double sign_4 = lines[3].direction.dot(lines[1].direction) > 0 ? 1 : -1;

  const OffsetWristGeometry geometry{.shoulder_x = arm->x,
                                     .lateral = wrist_A.y(),
                                     .upper = arm->upper,
                                     .fore = fore.norm(),
                                     .wrist_z = (wrist_A - axis_4).dot(w5)};
  if (geometry.fore < kLineTolerance) return nullptr;
  CanonicalArm canonical;
  canonical.add(kBaseZ, Vector3d::Zero(), 1, 0);
  canonical.add(kBaseY, {arm->x, geometry.lateral, 0}, 1, arm->upper_rad);
  canonical.add(kBaseY, {0, 0, arm->upper}, arm->sign_3, fore_rad - arm->upper_rad);
  canonical.add(kBaseY, {0, 0, geometry.fore}, sign_4, wrist_rad - fore_rad);
  canonical.add(kBaseZ, {0, 0, geometry.wrist_z}, 1, std::atan2(-w6.x(), w6.y()));
  canonical.add(kBaseY, Vector3d::Zero(), 1, 0);
  auto placement = canonical.match(model, arm->X_BA);
  if (!placement) return nullptr;
  return std::make_unique<PlacedIk>(model, std::move(*placement),
                                    std::make_unique<OffsetWristIk>(model, geometry));
}

}  // namespace aprsim::robot
