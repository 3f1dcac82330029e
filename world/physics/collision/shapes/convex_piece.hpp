#pragma once

#include <Eigen/Geometry>

#include "world/api/values/piece.hpp"
#include "world/physics/collision/shapes/aabb.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/physics/collision/shapes/nearness.hpp"
#include "world/physics/collision/shapes/polytope.hpp"
#include "world/physics/collision/shapes/prism.hpp"
#include "world/scene/model/outline.hpp"

namespace aprsim::physics {

/// Kinds of convex shapes that contacts are generated between.
enum class ConvexKind { kBox, kPrism, kHull, kRound, kCapsule };

/// A convex shape about the origin of its frame, as contact generation takes it. It owns nothing.
struct ConvexShape {
  ConvexKind kind = ConvexKind::kBox;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< of the box around it; of a box itself
  const detail::GearShape* round = nullptr;        ///< kRound: of one or several pieces
  const detail::Prism* prism = nullptr;            ///< kPrism
  const scene::Outline* outline = nullptr;         ///< kPrism, about the origin; may be missing
  const detail::Polytope* polytope = nullptr;  ///< kPrism and kHull; of a prism it may be missing
  double radius_m = 0, half_length_m = 0;      ///< kCapsule
};

[[nodiscard]] ConvexShape box_shape(const Eigen::Vector3d& size);
[[nodiscard]] ConvexShape round_shape(const detail::GearShape& round);
[[nodiscard]] ConvexShape capsule_shape(double radius_m, double half_length_m);

/// A piece of a part or fixture, prepared for contact generation.
class ConvexPiece {
 public:
  explicit ConvexPiece(const api::Piece& piece);

  [[nodiscard]] ConvexShape shape() const;
  /// Its frame, whose origin is the middle of the box around it, in that of the part.
  [[nodiscard]] const Eigen::Isometry3d& X_BP() const { return X_BP_; }
  [[nodiscard]] const Eigen::Vector3d& size() const { return size_; }
  /// Tight bounds. `X_WP`: pose of the piece.
  [[nodiscard]] Aabb bounds(const Eigen::Isometry3d& X_WP) const;
  /// Signed distance of a point in its frame, negative inside, and its gradient.
  [[nodiscard]] detail::Nearness nearness(const Eigen::Vector3d& p_P) const;
  /// Largest distance of a point of it from a point in its frame.
  [[nodiscard]] double farthest(const Eigen::Vector3d& p_P) const;

 private:
  struct Fill;

  ConvexKind kind_ = ConvexKind::kBox;
  Eigen::Isometry3d X_BP_;
  Eigen::Vector3d size_;
  detail::GearShape round_;
  detail::Prism prism_;
  scene::Outline outline_;
  detail::Polytope polytope_;
  double radius_m_ = 0, half_length_m_ = 0;
};

}  // namespace aprsim::physics
