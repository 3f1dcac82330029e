#pragma once

#include <variant>

#include <Eigen/Geometry>

#include "world/robot/arm_model.hpp"

/// What stands between a camera and a point.
namespace aprsim::sensors {

using Shape = decltype(robot::LinkShape::shape);

/// A solid in the world that hides what is behind it.
struct Occluder {
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Shape shape;
  double bound_m = 0;  ///< radius of a sphere around the shape's origin that holds all of it
};

[[nodiscard]] double bounding_radius(const Shape& shape);

/// Distance of a point to the segment from a to b.
[[nodiscard]] double distance_to_segment(const Eigen::Vector3d& point, const Eigen::Vector3d& a,
                                         const Eigen::Vector3d& b);

/// True if the segment from a to b has a point inside the solid. Exact for every shape.
[[nodiscard]] bool hides(const Occluder& occluder, const Eigen::Vector3d& a_W,
                         const Eigen::Vector3d& b_W);

}  // namespace aprsim::sensors
