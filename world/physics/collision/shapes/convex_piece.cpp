#include "world/physics/collision/shapes/convex_piece.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "world/scene/model/pieces.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

}  // namespace

ConvexShape box_shape(const Vector3d& size) {
  ConvexShape shape;
  shape.size = size;
  return shape;
}

ConvexShape round_shape(const detail::GearShape& round) {
  ConvexShape shape;
  shape.kind = ConvexKind::kRound;
  shape.size = {2 * round.r_max, 2 * round.r_max, round.z_high - round.z_low};
  shape.round = &round;
  return shape;
}

ConvexShape capsule_shape(double radius_m, double half_length_m) {
  ConvexShape shape;
  shape.kind = ConvexKind::kCapsule;
  shape.size = {2 * radius_m, 2 * radius_m, 2 * (radius_m + half_length_m)};
  shape.radius_m = radius_m;
  shape.half_length_m = half_length_m;
  return shape;
}

/// Takes over the shape of a piece, moved by -centre.
struct ConvexPiece::Fill {
  ConvexPiece& to;
  Vector3d centre;

  void operator()(const api::BoxPiece& box) const {
    to.kind_ = ConvexKind::kBox;
    to.prism_ = detail::box_prism(-0.5 * box.size, 0.5 * box.size);
    to.polytope_.set_prism(to.prism_);
  }
  void operator()(const api::ConePiece& cone) const {
    // A tip is a disc of 1 um: a circle without radius has no direction.
    constexpr double kTip = 1e-6;
    const double half = 0.5 * cone.height_m;
    to.kind_ = ConvexKind::kRound;
    to.round_ = detail::frustum_shape(-half, std::max(kTip, cone.bottom_radius_m), half,
                                      std::max(kTip, cone.top_radius_m));
  }
  void operator()(const api::CapsulePiece& capsule) const {
    to.kind_ = ConvexKind::kCapsule;
    to.radius_m_ = capsule.radius_m;
    to.half_length_m_ = 0.5 * capsule.length_m;
  }
  void operator()(const api::PrismPiece& prism) const {
    to.kind_ = ConvexKind::kPrism;
    std::vector<Eigen::Vector2d> corners = prism.corners;
    for (Eigen::Vector2d& corner : corners) corner -= centre.head<2>();
    to.outline_ = scene::outline_of(std::move(corners));
    to.prism_.set_sides(to.outline_.corners, to.outline_.normals);
    to.prism_.z0 = -0.5 * prism.height_m;
    to.prism_.z1 = 0.5 * prism.height_m;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& corner : to.outline_.corners) sum += corner;
    to.prism_.middle << sum / to.prism_.sides, 0;
    to.polytope_.set_prism(to.prism_);
  }
  void operator()(const api::HullPiece& hull) const {
    to.kind_ = ConvexKind::kHull;
    api::HullPiece moved = hull;
    for (Vector3d& corner : moved.corners) corner -= centre;
    to.polytope_.set_hull(moved);
  }
};

ConvexPiece::ConvexPiece(const api::Piece& piece) {
  const Eigen::AlignedBox3d box = scene::own_bounds_of(piece);
  size_ = box.sizes();
  X_BP_ = piece.X_BP.isometry() * Eigen::Translation3d(box.center());
  std::visit(Fill{*this, box.center()}, piece.shape);
}

ConvexShape ConvexPiece::shape() const {
  switch (kind_) {
    case ConvexKind::kRound:
      return round_shape(round_);
    case ConvexKind::kCapsule:
      return capsule_shape(radius_m_, half_length_m_);
    default:
      break;
  }
  ConvexShape shape = box_shape(size_);
  shape.kind = kind_;
  shape.polytope = &polytope_;
  if (kind_ != ConvexKind::kHull) shape.prism = &prism_;
  if (kind_ == ConvexKind::kPrism) shape.outline = &outline_;
  return shape;
}

Aabb ConvexPiece::bounds(const Isometry3d& X_WP) const {
  const Eigen::Matrix3d& R = X_WP.linear();
  const Vector3d& c = X_WP.translation();
  if (kind_ == ConvexKind::kBox) return aabb_of_box(size_, X_WP);
  if (kind_ == ConvexKind::kCapsule) {
    const Vector3d reach = half_length_m_ * R.col(2).cwiseAbs() + Vector3d::Constant(radius_m_);
    return {c - reach, c + reach};
  }
  Aabb bounds{c, c};
  const auto include = [&bounds](const Vector3d& low, const Vector3d& high) {
    bounds.min = bounds.min.cwiseMin(low);
    bounds.max = bounds.max.cwiseMax(high);
  };
  if (kind_ == ConvexKind::kRound) {
    // A disc projects to r sqrt(1 - c^2) on an axis at cosine c.
    const Vector3d wide = (1 - R.col(2).array().square()).max(0).sqrt();
    const detail::Piece& round = round_.pieces[0];
    const Vector3d low = c + round.z0 * R.col(2), high = c + round.z1 * R.col(2);
    include(low - round.r0 * wide, low + round.r0 * wide);
    include(high - round.r1 * wide, high + round.r1 * wide);
    return bounds;
  }
  for (const Vector3d& corner : polytope_.corners) include(X_WP * corner, X_WP * corner);
  return bounds;
}

detail::Nearness ConvexPiece::nearness(const Vector3d& p_P) const {
  switch (kind_) {
    case ConvexKind::kBox:
      return detail::nearness(size_, p_P);
    case ConvexKind::kPrism:
      return detail::nearness(prism_, p_P);
    case ConvexKind::kHull:
      return detail::nearness(polytope_, p_P);
    case ConvexKind::kRound:
      return detail::nearness(round_.pieces[0], p_P);
    case ConvexKind::kCapsule:
      break;
  }
  return detail::capsule_nearness(radius_m_, half_length_m_, p_P);
}

double ConvexPiece::farthest(const Vector3d& p_P) const {
  if (kind_ == ConvexKind::kCapsule) {
    const Vector3d end(0, 0, half_length_m_);
    return radius_m_ + std::max((p_P - end).norm(), (p_P + end).norm());
  }
  if (kind_ == ConvexKind::kRound) {
    const double beside = p_P.head<2>().norm();
    const detail::Piece& round = round_.pieces[0];
    return std::max(std::hypot(beside + round.r0, p_P.z() - round.z0),
                    std::hypot(beside + round.r1, p_P.z() - round.z1));
  }
  double most = 0;
  for (const Vector3d& corner : polytope_.corners) most = std::max(most, (corner - p_P).norm());
  return most;
}

}  // namespace aprsim::physics
