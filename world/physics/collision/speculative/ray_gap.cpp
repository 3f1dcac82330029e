#include "world/physics/collision/speculative/ray_gap.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/physics/collision/shapes/pocket.hpp"
#include "world/physics/collision/shapes/pocket_outline.hpp"
#include "world/scene/model/part_shapes.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

/// Where a line is inside something convex: from `enter` to `leave`, none when enter > leave.
struct Span {
  double enter = -kNoHit, leave = kNoHit;

  void cut(double from, double to) {
    enter = std::max(enter, from);
    leave = std::min(leave, to);
  }
  /// First distance at or after the origin.
  [[nodiscard]] double first() const {
    return enter > leave || leave < 0 ? kNoHit : std::max(0.0, enter);
  }
};

/// Slab method (Kay and Kajiya 1986) along one axis.
void cut_slab(double p, double d, double low, double high, Span& span) {
  // A ray parallel to the slab is inside for all distances or for none.
  if (d == 0) {
    if (p < low || p > high) span.leave = -kNoHit;
    return;
  }
  const double a = (low - p) / d, b = (high - p) / d;
  span.cut(std::min(a, b), std::max(a, b));
}

/// Inside the cone r < r0 + slope (z - z0), which is convex between the planes of a frustum.
void cut_cone(const Vector3d& p, const Vector3d& d, double z0, double r0, double slope,
              Span& span) {
  const double r = r0 + slope * (p.z() - z0), rate = slope * d.z();
  // |p_xy + t d_xy|^2 < (r + rate t)^2 is a t^2 + 2 b t + c < 0 (ray against cone: Ericson 2005,
  // ch. 5.3.7, for a cylinder with rate 0).
  const double a = d.head<2>().squaredNorm() - rate * rate;
  const double b = p.head<2>().dot(d.head<2>()) - r * rate;
  const double c = p.head<2>().squaredNorm() - r * r;
  if (std::abs(a) < 1e-15) {  // parallel to the side
    if (std::abs(b) < 1e-15) {
      if (c > 0) span.leave = -kNoHit;
    } else if (b > 0) {
      span.cut(-kNoHit, -c / (2 * b));
    } else {
      span.cut(-c / (2 * b), kNoHit);
    }
    return;
  }
  const double discriminant = b * b - a * c;
  if (discriminant < 0) {
    if (a > 0) span.leave = -kNoHit;
    return;
  }
  const double root = std::sqrt(discriminant);
  const double low = std::min((-b - root) / a, (-b + root) / a);
  const double high = std::max((-b - root) / a, (-b + root) / a);
  if (a > 0) {
    span.cut(low, high);
  } else if (rate > 0) {  // steeper than the cone: it is inside on one side only
    span.cut(high, kNoHit);
  } else {
    span.cut(-kNoHit, low);
  }
}

double to_frustum(const Vector3d& p, const Vector3d& d, double z0, double r0, double z1,
                  double slope) {
  Span span;
  cut_slab(p.z(), d.z(), z0, z1, span);
  cut_cone(p, d, z0, r0, slope, span);
  return span.first();
}

/// Inside a half space. `height`: over its plane at the origin; `rate`: its change along the ray.
void cut_half_space(double height, double rate, Span& span) {
  if (rate == 0) {
    if (height > 0) span.leave = -kNoHit;
  } else if (rate > 0) {
    span.cut(-kNoHit, -height / rate);
  } else {
    span.cut(-height / rate, kNoHit);
  }
}

/// The part of a ray in a tray's slab with an outline, in the tray frame.
Span slab_span(const scene::TrayType& tray, const Vector3d& p, const Vector3d& d) {
  Span span;
  cut_slab(p.z(), d.z(), -tray.thickness_m, 0, span);
  for (std::size_t i = 0; i < tray.outline->corners.size(); ++i) {
    const Eigen::Vector2d& n = tray.outline->normals[i];
    cut_half_space(n.dot(p.head<2>() - tray.outline->corners[i]), n.dot(d.head<2>()), span);
  }
  return span;
}

Span box_span(const Vector3d& size, const Vector3d& p, const Vector3d& d) {
  Span span;
  for (int axis = 0; axis < 3; ++axis) {
    cut_slab(p[axis], d[axis], -0.5 * size[axis], 0.5 * size[axis], span);
  }
  return span;
}

/// Whether a point on or under the top face is within the pocket's mouth, seen from above.
bool is_in_mouth(const scene::Slot& slot, const Vector3d& p) {
  if (!slot.pocket.outline) {
    return (p.head<2>() - slot.xy).norm() < detail::PocketProfile(slot).r_mouth;
  }
  return detail::PocketOutline(slot).behind({p.x(), p.y(), 0}) < 0;
}

}  // namespace

double distance_to_gear(const scene::GearType& gear, const Eigen::Isometry3d& X_WG,
                        const Ray& ray) {
  const Vector3d p = X_WG.inverse() * ray.p_W, d = X_WG.linear().transpose() * ray.d_W;
  // A union of convex pieces: the first hit is the least over the pieces.
  const detail::GearShape shape = gear;
  double nearest = kNoHit;
  for (int i = 0; i < shape.piece_count; ++i) {
    const detail::Piece& piece = shape.pieces[static_cast<std::size_t>(i)];
    nearest = std::min(nearest, to_frustum(p, d, piece.z0, piece.r0, piece.z1, piece.slope));
  }
  return nearest;
}

double distance_to_tray(const scene::TrayType& tray, const Eigen::Isometry3d& X_WP,
                        const Ray& ray) {
  const Eigen::AlignedBox3d slab = scene::slab_of(tray);
  const Vector3d p = X_WP.inverse() * ray.p_W, d = X_WP.linear().transpose() * ray.d_W;
  const Span span =
      tray.outline ? slab_span(tray, p, d) : box_span(slab.sizes(), p - slab.center(), d);
  const double to_slab = span.first();
  // Pockets open upwards, so that only a falling ray can enter one.
  if (to_slab == kNoHit || d.z() >= 0) return to_slab;
  const Vector3d hit = p + to_slab * d;
  for (const scene::Slot& slot : tray.slots) {
    if (!is_in_mouth(slot, hit) || hit.z() < -slot.pocket.depth_m) continue;
    // In a pocket's mouth: to the floor; its wall is too near to its rim to hold a lip.
    return std::max(to_slab, (-slot.pocket.depth_m - p.z()) / d.z());
  }
  return to_slab;
}

double distance_to_box(const Vector3d& size, const Eigen::Isometry3d& X_WS, const Ray& ray) {
  return box_span(size, X_WS.inverse() * ray.p_W, X_WS.linear().transpose() * ray.d_W).first();
}

double distance_to_piece(const ConvexPiece& piece, const Eigen::Isometry3d& X_WP, const Ray& ray) {
  constexpr int kMost = 64;
  constexpr double kSame = 1e-10;  // [m]
  const Eigen::Isometry3d X_PW = X_WP.inverse(Eigen::Isometry);
  const Vector3d p = X_PW * ray.p_W, d = X_PW.linear() * ray.d_W;
  // Newton's method for the root of a convex function: from outside no step goes beyond it, but for
  // rounding where the ray grazes; then halves of the bracket.
  double t = 0, outside = 0, inside = kNoHit;
  for (int i = 0; i < kMost; ++i) {
    const detail::Nearness near = piece.nearness(p + t * d);
    if (std::abs(near.distance) <= kSame || (near.distance < 0 && t == 0)) return t;
    const double rate = near.out.dot(d);
    (near.distance > 0 ? outside : inside) = t;
    if (inside == kNoHit && rate >= 0) return kNoHit;
    t -= near.distance / rate;
    if (inside != kNoHit && !(t > outside && t < inside)) t = 0.5 * (outside + inside);
  }
  return t;
}

}  // namespace aprsim::physics
