#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/collision/pairs/capsule_contacts.hpp"
#include "world/physics/collision/reduction/contact_reduction.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/physics/collision/shapes/pocket.hpp"
#include "world/physics/collision/shapes/pocket_outline.hpp"
#include "world/physics/collision/shapes/polytope.hpp"
#include "world/physics/collision/shapes/prism.hpp"

/// Contacts in pockets with an outline, in the tray's frame, normals into the body. A convex
/// polyhedron meets walls and floor with its corners, and the edges of the mouth with its edges;
/// the void is convex, so that these are all features that can touch. Round bodies meet the
/// material around the void as convex pieces.
namespace aprsim::physics::detail {

/// Pockets with an outline that one body can reach at once, in the tray's order.
class NearbyOutlines {
 public:
  static constexpr std::size_t kMost = 8;

  /// All that a circle in the tray's plane reaches.
  NearbyOutlines(const scene::TrayType& tray, const Eigen::Vector2d& centre, double radius);

  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] const PocketOutline* begin() const { return items_.data(); }
  [[nodiscard]] const PocketOutline* end() const { return items_.data() + count_; }
  /// Whether a contact with the slab is none: its point is in a pocket's void, or the way into it
  /// is shorter than the contact's depth.
  [[nodiscard]] bool take(const Eigen::Vector3d& p, double depth) const;
  /// Moves what the pockets leave of the slab's contacts to `out`.
  void keep_on_slab(const Candidates& on_slab, Candidates& out) const;

 private:
  std::array<PocketOutline, kMost> items_;
  std::size_t count_ = 0;
};

/// The tray's material without the voids of all pockets near the body.
struct TrayMaterial {
  const Prism& slab;
  std::span<const PocketProfile> round;
  const NearbyOutlines& outlines;

  /// Whether the material at a point behind a wall of `own` is the tray's, and no other way out of
  /// it is shorter than `depth`.
  [[nodiscard]] bool holds(const PocketOutline& own, const Eigen::Vector3d& p, double depth) const;
};

/// Adds where the line between two points on the top face passes the edge of a mouth.
void across_outline(const PocketOutline& pocket, const Candidate& from, const Candidate& to,
                    Candidates& out);

void polytope_in_outline(const Polytope& polytope, const Eigen::Isometry3d& X_PS,
                         const PocketOutline& pocket, const TrayMaterial& material,
                         Candidates& out);

void gear_in_outline(const GearShape& gear, const Eigen::Isometry3d& X_PG,
                     const PocketOutline& pocket, const TrayMaterial& material, Candidates& out);

void capsule_in_outline(const Segment& segment, double radius_m, const PocketOutline& pocket,
                        const TrayMaterial& material, Candidates& out);

}  // namespace aprsim::physics::detail
