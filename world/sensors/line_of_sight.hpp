#pragma once

#include <optional>
#include <variant>

#include <Eigen/Geometry>

#include "world/robot/model/arm_model.hpp"

/// Occlusion of a camera's line of sight or a sensor's beam.
namespace aprsim::sensors {

using Shape = decltype(robot::LinkShape::shape);

/// Something opaque in the world.
struct Occluder {
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Shape shape;
  double bound_m = 0;  ///< radius of a sphere around the shape's origin that holds all of it
  int body = -1;       ///< the free body that it is part of, as numbered in the cell; -1 = none
};

[[nodiscard]] double bounding_radius(const Shape& shape);

/// Distance of a point to the segment from a to b.
[[nodiscard]] double distance_to_segment(const Eigen::Vector3d& point, const Eigen::Vector3d& a,
                                         const Eigen::Vector3d& b);

/// Where the way from a to b first meets the occluder, as a fraction of the way; 0 if a is inside.
/// Exact for every shape.
[[nodiscard]] std::optional<double> first_hit(const Occluder& occluder, const Eigen::Vector3d& a_W,
                                              const Eigen::Vector3d& b_W);

/// True if the segment from a to b has a point inside the occluder.
[[nodiscard]] inline bool hides(const Occluder& occluder, const Eigen::Vector3d& a_W,
                                const Eigen::Vector3d& b_W) {
  return first_hit(occluder, a_W, b_W).has_value();
}

}  // namespace aprsim::sensors
