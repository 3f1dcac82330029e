#include "world/scene/checks/scene_solids.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "world/scene/model/part_shapes.hpp"
#include "world/scene/model/pieces.hpp"

namespace aprsim::scene {
namespace {

constexpr double kBeltThickness = 1e-3;

Solid solid_of(const Frustum& frustum, const Eigen::Isometry3d& X_WP) {
  return {
      FrustumSolid{(frustum.z_high - frustum.z_low) / 2, frustum.radius_low, frustum.radius_high},
      X_WP * Eigen::Translation3d(0, 0, (frustum.z_low + frustum.z_high) / 2)};
}

struct SolidOf {
  Eigen::Isometry3d X;

  Solid operator()(const api::BoxPiece& box) const { return {BoxSolid{box.size / 2}, X}; }
  Solid operator()(const api::ConePiece& cone) const {
    return {FrustumSolid{cone.height_m / 2, cone.bottom_radius_m, cone.top_radius_m}, X};
  }
  Solid operator()(const api::CapsulePiece& capsule) const {
    return {CapsuleSolid{capsule.radius_m, capsule.length_m / 2}, X};
  }
  Solid operator()(const api::PrismPiece& prism) const {
    return {PrismSolid{outline_of(prism.corners), prism.height_m / 2}, X};
  }
  Solid operator()(const api::HullPiece& hull) const {
    HullSolid solid;
    const Eigen::Vector3d centre = own_bounds_of({hull, {}}).center();
    for (const Eigen::Vector3d& corner : hull.corners) solid.corners.push_back(corner - centre);
    for (const auto& face : hull.faces) {
      const auto at = [&](std::size_t k) -> const Eigen::Vector3d& {
        return hull.corners[static_cast<std::size_t>(face[k])];
      };
      solid.normals.push_back((at(1) - at(0)).cross(at(2) - at(0)).normalized());
    }
    return {std::move(solid), X * Eigen::Translation3d(centre)};
  }
};

using Segments = std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>;

/// Lines on the surface whose hull is the piece; round ones by 48 lines around.
struct SegmentsOf {
  static constexpr int kAround = 48, kUp = 12;

  static Segments lathe(const std::vector<Eigen::Vector2d>& profile) {
    Segments out;
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      const auto at = [&](const Eigen::Vector2d& p) {
        return Eigen::Vector3d(p.x() * std::cos(angle), p.x() * std::sin(angle), p.y());
      };
      for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
        out.emplace_back(at(profile[k]), at(profile[k + 1]));
      }
    }
    return out;
  }
  static Segments prism(const std::vector<Eigen::Vector2d>& corners, double half) {
    Segments out;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
      out.emplace_back(Eigen::Vector3d(a.x(), a.y(), -half), Eigen::Vector3d(a.x(), a.y(), half));
      for (const double z : {-half, half}) {
        out.emplace_back(Eigen::Vector3d(a.x(), a.y(), z), Eigen::Vector3d(b.x(), b.y(), z));
      }
    }
    return out;
  }

  Segments operator()(const api::BoxPiece& box) const {
    const double x = box.size.x() / 2, y = box.size.y() / 2;
    return prism({{-x, -y}, {x, -y}, {x, y}, {-x, y}}, box.size.z() / 2);
  }
  Segments operator()(const api::ConePiece& cone) const {
    const double half = cone.height_m / 2;
    return lathe({{cone.bottom_radius_m, -half}, {cone.top_radius_m, half}});
  }
  Segments operator()(const api::CapsulePiece& capsule) const {
    std::vector<Eigen::Vector2d> profile;
    for (int i = 0; i <= 2 * kUp + 1; ++i) {
      const int step = i <= kUp ? i : i - 1;  // the middle one twice, for both ends of the segment
      const double turn = std::numbers::pi * (static_cast<double>(step) / (2 * kUp) - 0.5);
      const double end = (i <= kUp ? -0.5 : 0.5) * capsule.length_m;
      profile.emplace_back(capsule.radius_m * std::cos(turn),
                           end + capsule.radius_m * std::sin(turn));
    }
    return lathe(profile);
  }
  Segments operator()(const api::PrismPiece& piece) const {
    return prism(piece.corners, piece.height_m / 2);
  }
  Segments operator()(const api::HullPiece& hull) const {
    Segments out;
    for (const auto& face : hull.faces) {
      for (std::size_t k = 0; k < face.size(); ++k) {
        out.emplace_back(hull.corners[static_cast<std::size_t>(face[k])],
                         hull.corners[static_cast<std::size_t>(face[(k + 1) % face.size()])]);
      }
    }
    return out;
  }
};

constexpr double kInPocket = 1e-4;  // [m] that a piece may overlap the pocket's surface by

bool is_in_pocket(const Eigen::Vector3d& p, const Slot& slot) {
  const Pocket& pocket = slot.pocket;
  const double depth = -p.z();
  if (depth > pocket.depth_m + kInPocket) return false;
  const double chamfer =
      std::max(0.0, pocket.chamfer_m - depth) * std::tan(pocket.chamfer_angle_rad);
  if (pocket.outline) {
    const Eigen::Vector2d p_S = Eigen::Rotation2Dd(-slot.yaw_rad) * (p.head<2>() - slot.xy);
    return pocket.outline->depth_of(p_S) >= -chamfer - kInPocket;
  }
  double wall = pocket.top_radius_m + (pocket.floor_radius_m - pocket.top_radius_m) *
                                          std::clamp(depth / pocket.depth_m, 0.0, 1.0);
  return (p.head<2>() - slot.xy).norm() <= wall + chamfer + kInPocket;
}

}  // namespace

Solid solid_of(const api::Piece& piece, const Pose& X_WP) {
  return std::visit(SolidOf{X_WP.isometry() * piece.X_BP.isometry()}, piece.shape);
}

bool lies_in_pocket(const api::Piece& piece, const Pose& X_WB, const TrayType& tray,
                    const Pose& X_WP) {
  const Eigen::Isometry3d X_PS =
      X_WP.isometry().inverse() * X_WB.isometry() * piece.X_BP.isometry();
  // The part under the top face is the hull of its corners there and of where edges pass the face,
  // and a pocket is convex.
  std::vector<Eigen::Vector3d> under;
  for (const auto& [from, to] : std::visit(SegmentsOf{}, piece.shape)) {
    const Eigen::Vector3d a = X_PS * from, b = X_PS * to;
    if (a.z() < 0) under.push_back(a);
    if (b.z() < 0) under.push_back(b);
    if ((a.z() < 0) != (b.z() < 0)) under.push_back(a + a.z() / (a.z() - b.z()) * (b - a));
  }
  return std::ranges::any_of(tray.slots, [&under](const Slot& slot) {
    return std::ranges::all_of(under, [&slot](const auto& p) { return is_in_pocket(p, slot); });
  });
}

Solid solid_of(const StaticBox& box) { return {BoxSolid{box.size / 2}, box.X_WS.isometry()}; }

Solid solid_of(const Conveyor& conveyor) {
  return {BoxSolid{{conveyor.length_m / 2, conveyor.width_m / 2, kBeltThickness / 2}},
          conveyor.X_WC.isometry() * Eigen::Translation3d(0, 0, -kBeltThickness / 2)};
}

Solid solid_of(const TrayType& type, const Pose& X_WP) {
  const Eigen::AlignedBox3d slab = slab_of(type);
  if (type.outline) {
    PrismSolid prism{*type.outline, type.thickness_m / 2};
    for (auto& corner : prism.outline.corners) corner -= slab.center().head<2>();
    return {std::move(prism), X_WP.isometry() * Eigen::Translation3d(slab.center())};
  }
  return {BoxSolid{slab.sizes() / 2}, X_WP.isometry() * Eigen::Translation3d(slab.center())};
}

std::array<Solid, 3> solids_of(const GearType& type, const Pose& X_WP) {
  const GearShapes gear = shapes_of(type);
  const Eigen::Isometry3d X = X_WP.isometry();
  return {solid_of(gear.disc, X), solid_of(gear.peg, X), solid_of(gear.hub, X)};
}

}  // namespace aprsim::scene
