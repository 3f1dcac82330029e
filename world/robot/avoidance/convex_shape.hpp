#pragma once

#include <cstdint>

#include <Eigen/Geometry>

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// A box or a cylinder about z, grown by a radius: a capsule is a segment with a radius, a sphere a
/// point with one. Origin at its centre.
struct ConvexShape {
  enum class Core : std::uint8_t { kBox, kCylinder };
  friend constexpr Core last_of(Core) { return Core::kCylinder; }

  Core core = Core::kBox;
  /// Half extents of the box; of a cylinder its radius, twice, and half its height [m].
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  double radius_m = 0;

  /// Radius of the sphere around it.
  [[nodiscard]] double bounding_radius() const {
    const double across = core == Core::kBox ? half.head<2>().norm() : half.x();
    return std::hypot(across, half.z()) + radius_m;
  }
  /// The core's farthest point in a direction.
  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& direction) const;
  /// The box around it at a pose.
  [[nodiscard]] Eigen::AlignedBox3d bounds(const Eigen::Isometry3d& X) const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [core, half, radius_m] = self;
    io(core, half, radius_m);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(half.minCoeff() >= 0 && radius_m >= 0, "a shape of negative size");
  }
};

[[nodiscard]] ConvexShape convex_shape(const decltype(LinkShape::shape)& shape);
[[nodiscard]] inline ConvexShape convex_box(const Eigen::Vector3d& size) {
  return {.half = 0.5 * size};
}

/// Lower bound of the distance of two shapes [m], within 10 um of it; negative where they overlap:
/// then at least as deep as the overlap. Ends early with any lower bound above `enough`. Distance
/// of the cores by Gilbert, Johnson & Keerthi 1988, each iteration of which gives a lower bound;
/// the depth is the least overlap along the shapes' own axes. Thread: any.
[[nodiscard]] double distance_bound(const ConvexShape& a, const Eigen::Isometry3d& X_WA,
                                    const ConvexShape& b, const Eigen::Isometry3d& X_WB,
                                    double enough);

}  // namespace aprsim::robot
