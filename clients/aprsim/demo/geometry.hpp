#pragma once

#include <Eigen/Geometry>

#include "aprsim/v1/geometry.pb.h"
#include "crcl/values.hpp"

/// Poses between the wires. Frames: W world, R a robot's CRCL frame, T tool, P part or tray, S
/// slot.
namespace aprsim::client {

[[nodiscard]] Eigen::Isometry3d isometry(const v1::Pose& pose);

/// A CRCL pose in millimetres.
[[nodiscard]] crcl::Pose crcl_pose_mm(const Eigen::Isometry3d& X);

/// A tool that points straight down: z down, x turned by yaw about the world's z.
[[nodiscard]] Eigen::Isometry3d tool_down(const Eigen::Vector3d& p_WT, double yaw_rad);

/// Yaw of a tool that points about down, within -pi and pi.
[[nodiscard]] double tool_yaw(const Eigen::Isometry3d& X_WT);

/// The angle turned by whole turns into -pi .. pi.
[[nodiscard]] double wrapped(double angle_rad);

}  // namespace aprsim::client
