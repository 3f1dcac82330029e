#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// A gear, tray or part of a scene with the outline that sensors, faults and descriptions use.
/// Frames as in api::BodyDescription.
struct FreeBody {
  std::string name, type;
  api::BodyKind kind = api::BodyKind::kGear;
  double mass_kg = 0;
  // gears only [m]
  double disc_radius_m = 0, disc_height_m = 0, peg_radius_m = 0, peg_top_m = 0;
  // trays: the slab without its pockets, or the box around it; parts: around all pieces [m]
  Eigen::AlignedBox3d slab;
  std::optional<Outline> outline;  ///< of the slab, where it is no box
  std::vector<api::Piece> pieces;  ///< of parts only
  std::vector<Slot> outlined;      ///< of trays: the slots whose pockets have an outline

  /// Whether a point of the tray's plane lies on the slab.
  [[nodiscard]] bool covers(const Eigen::Vector2d& p_P) const;

  /// Whether a point lies in a pocket with an outline, under the tray's top face, and the line to
  /// it from a point over the tray passes the pocket's mouth. Both in the tray's frame.
  [[nodiscard]] bool shows_in_pocket(const Eigen::Vector3d& from_P,
                                     const Eigen::Vector3d& p_P) const;

  [[nodiscard]] bool is_gear() const { return kind == api::BodyKind::kGear; }
  [[nodiscard]] bool is_part() const { return kind == api::BodyKind::kPart; }
  [[nodiscard]] bool is_tray() const { return !is_gear() && !is_part(); }
};

/// Free bodies as a cell numbers them: trays first, then gears, then parts.
[[nodiscard]] std::vector<FreeBody> free_bodies_of(const Scene& scene);

/// True if a gear's origin is over a tray's slab and within 5 mm of its top face.
[[nodiscard]] bool stands_on(const Eigen::Isometry3d& X_WG, const Eigen::Isometry3d& X_WP,
                             const FreeBody& tray);

}  // namespace aprsim::scene
