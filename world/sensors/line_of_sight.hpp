#pragma once

#include <optional>
#include <variant>

#include <Eigen/Geometry>

#include "world/robot/model/arm_model.hpp"
#include "world/scene/model/parts.hpp"

/// Occlusion of a camera's line of sight or a sensor's beam.
namespace aprsim::sensors {

/// A convex prism along z, centred half-way up. `outline` must outlive it; `middle` is where its
/// frame's origin lies in the outline's frame.
struct PrismShape {
  const scene::Outline* outline = nullptr;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double height_m = 0;
};

using Shape = std::variant<robot::BoxShape, robot::CapsuleShape, robot::CylinderShape,
                           robot::SphereShape, PrismShape>;

/// A link's primitive as such a shape.
[[nodiscard]] Shape shape_of(const robot::LinkShape& part);

/// A tray's slab in the frame of its middle: a box, or a prism of the outline.
[[nodiscard]] Shape slab_shape(const Eigen::AlignedBox3d& slab,
                               const std::optional<scene::Outline>& outline);

/// Something opaque in the world.
struct Occluder {
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Shape shape;
  double bound_m = 0;  ///< radius of a sphere around the shape's origin that holds all of it
  int body = -1;       ///< the free body that it is part of, as numbered in the cell; -1 = none
};

[[nodiscard]] double bounding_radius(const Shape& shape);

/// A piece of a part; a cone as the cylinder around it, prisms and hulls as the boxes around them.
[[nodiscard]] Occluder occluder_of(const api::Piece& piece, const Eigen::Isometry3d& X_WB);

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
