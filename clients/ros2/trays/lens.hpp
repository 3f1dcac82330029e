#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "aprsim/v1/cell.pb.h"

namespace aprsim::ros2 {

/// A pose as a transform, in metres.
[[nodiscard]] Eigen::Isometry3d isometry_of(const v1::Pose& pose);

/// Place of a point in a camera's picture [px]; (0, 0) is the middle of the pixel at the top left.
/// Absent for points that the lens does not show. `in_camera`: metres. Distortion by Brown, as
/// v1::CameraDescription has it.
[[nodiscard]] std::optional<Eigen::Vector2d> pixel_of(const v1::CameraDescription& camera,
                                                      const Eigen::Vector3d& in_camera);

}  // namespace aprsim::ros2
