#include "clients/aprsim/demo/geometry.hpp"

#include <cmath>
#include <numbers>

namespace aprsim::client {
namespace {

crcl::Vector to_crcl(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

Eigen::Isometry3d isometry(const v1::Pose& pose) {
  const auto& p = pose.position_m();
  const auto& q = pose.orientation();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(p.x(), p.y(), p.z());
  X.linear() = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
  return X;
}

crcl::Pose crcl_pose_mm(const Eigen::Isometry3d& X) {
  crcl::Pose pose;
  pose.point = to_crcl(1e3 * X.translation());
  pose.x_axis = to_crcl(X.linear().col(0));
  pose.z_axis = to_crcl(X.linear().col(2));
  return pose;
}

Eigen::Isometry3d tool_down(const Eigen::Vector3d& p_WT, double yaw_rad) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() << c, s, 0, s, -c, 0, 0, 0, -1;
  X.translation() = p_WT;
  return X;
}

double tool_yaw(const Eigen::Isometry3d& X_WT) {
  return std::atan2(X_WT.linear()(1, 0), X_WT.linear()(0, 0));
}

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

}  // namespace aprsim::client
