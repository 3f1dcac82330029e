#include "world/sensors/line_of_sight.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "world/scene/model/pieces.hpp"

namespace aprsim::sensors {
namespace {

/// Part of the segment a + t d, t in [0, 1], that lies in something convex.
struct Span {
  double from = 0, to = 1;
  [[nodiscard]] bool empty() const { return from > to; }
};

constexpr Span kEmpty{1, 0};

Span cut(Span span, Span other) {
  return {std::max(span.from, other.from), std::min(span.to, other.to)};
}

/// Where |a + t d| <= half.
Span within_slab(double a, double d, double half) {
  if (d == 0) return std::abs(a) <= half ? Span{} : kEmpty;
  const double t1 = (-half - a) / d, t2 = (half - a) / d;
  return {std::min(t1, t2), std::max(t1, t2)};
}

/// Where height + t rate <= 0.
Span within_half_space(double height, double rate) {
  if (rate == 0) return height <= 0 ? Span{} : kEmpty;
  const double t = -height / rate;
  return rate > 0 ? Span{0, t} : Span{t, 1};
}

/// Where the squared length of a + t d stays within radius^2, for vectors of any dimension.
template <typename Vector>
Span within_radius(const Vector& a, const Vector& d, double radius) {
  const double dd = d.squaredNorm(), ad = a.dot(d), c = a.squaredNorm() - radius * radius;
  if (dd == 0) return c <= 0 ? Span{} : kEmpty;
  const double root = ad * ad - dd * c;
  if (root < 0) return kEmpty;
  return {(-ad - std::sqrt(root)) / dd, (-ad + std::sqrt(root)) / dd};
}

using Hit = std::optional<double>;

Hit entry(Span span) { return span.empty() ? Hit{} : Hit{span.from}; }

Hit nearer(Hit a, Hit b) {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}

/// The segment in the shape's frame.
struct Sight {
  Eigen::Vector3d a, d;

  [[nodiscard]] Hit on_cylinder(double radius, double length) const {
    const Span round =
        within_radius(Eigen::Vector2d(a.head<2>()), Eigen::Vector2d(d.head<2>()), radius);
    return entry(cut(cut(Span{}, round), within_slab(a.z(), d.z(), 0.5 * length)));
  }
  [[nodiscard]] Hit on_sphere(double z, double radius) const {
    const Eigen::Vector3d from_centre = a - Eigen::Vector3d(0, 0, z);
    return entry(cut(Span{}, within_radius(from_centre, d, radius)));
  }

  Hit operator()(const robot::BoxShape& box) const {
    Span span;
    for (int i = 0; i < 3; ++i) span = cut(span, within_slab(a[i], d[i], 0.5 * box.size[i]));
    return entry(span);
  }
  Hit operator()(const robot::CylinderShape& cylinder) const {
    return on_cylinder(cylinder.radius_m, cylinder.length_m);
  }
  Hit operator()(const robot::CapsuleShape& capsule) const {
    const double end = 0.5 * capsule.length_m;
    const Hit ends = nearer(on_sphere(end, capsule.radius_m), on_sphere(-end, capsule.radius_m));
    return nearer(on_cylinder(capsule.radius_m, capsule.length_m), ends);
  }
  Hit operator()(const robot::SphereShape& sphere) const { return on_sphere(0, sphere.radius_m); }
  Hit operator()(const PrismShape& prism) const {
    const auto& [corners, normals] = *prism.outline;
    Span span = cut(Span{}, within_slab(a.z(), d.z(), 0.5 * prism.height_m));
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d from_side = a.head<2>() + prism.middle - corners[i];
      span = cut(span, within_half_space(normals[i].dot(from_side), normals[i].dot(d.head<2>())));
    }
    return entry(span);
  }
};

struct BoundingRadius {
  double operator()(const robot::BoxShape& box) const { return 0.5 * box.size.norm(); }
  double operator()(const robot::CylinderShape& cylinder) const {
    return std::hypot(cylinder.radius_m, 0.5 * cylinder.length_m);
  }
  double operator()(const robot::CapsuleShape& capsule) const {
    return capsule.radius_m + 0.5 * capsule.length_m;
  }
  double operator()(const robot::SphereShape& sphere) const { return sphere.radius_m; }
  double operator()(const PrismShape& prism) const {
    double radius = 0;
    for (const Eigen::Vector2d& corner : prism.outline->corners) {
      radius = std::max(radius, (corner - prism.middle).norm());
    }
    return std::hypot(radius, 0.5 * prism.height_m);
  }
};

}  // namespace

Shape shape_of(const robot::LinkShape& part) {
  return std::visit([](const auto& shape) -> Shape { return shape; }, part.shape);
}

Shape slab_shape(const Eigen::AlignedBox3d& slab, const std::optional<scene::Outline>& outline) {
  if (!outline) return robot::BoxShape{slab.sizes()};
  return PrismShape{&*outline, slab.center().head<2>(), slab.sizes().z()};
}

double bounding_radius(const Shape& shape) { return std::visit(BoundingRadius{}, shape); }

double distance_to_segment(const Eigen::Vector3d& point, const Eigen::Vector3d& a,
                           const Eigen::Vector3d& b) {
  const Eigen::Vector3d d = b - a;
  const double dd = d.squaredNorm();
  const double t = dd > 0 ? std::clamp((point - a).dot(d) / dd, 0.0, 1.0) : 0.0;
  return (point - a - t * d).norm();
}

std::optional<double> first_hit(const Occluder& occluder, const Eigen::Vector3d& a_W,
                                const Eigen::Vector3d& b_W) {
  const Eigen::Isometry3d X_SW = occluder.X_WS.inverse();
  const Eigen::Vector3d a_S = X_SW * a_W;
  return std::visit(Sight{a_S, X_SW * b_W - a_S}, occluder.shape);
}

Occluder occluder_of(const api::Piece& piece, const Eigen::Isometry3d& X_WB) {
  const Eigen::AlignedBox3d box = scene::own_bounds_of(piece);
  Occluder out;
  out.X_WS = X_WB * piece.X_BP.isometry() * Eigen::Translation3d(box.center());
  if (const auto* cone = std::get_if<api::ConePiece>(&piece.shape)) {
    out.shape =
        robot::CylinderShape{std::max(cone->bottom_radius_m, cone->top_radius_m), cone->height_m};
  } else if (const auto* capsule = std::get_if<api::CapsulePiece>(&piece.shape)) {
    out.shape = robot::CapsuleShape{capsule->radius_m, capsule->length_m};
  } else {
    out.shape = robot::BoxShape{box.sizes()};
  }
  out.bound_m = bounding_radius(out.shape);
  return out;
}

}  // namespace aprsim::sensors
