#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// A gear or tray of a scene with the outline that sensors, faults and descriptions use. Frames as
/// in api::BodyDescription.
struct FreeBody {
  std::string name, type;
  api::BodyKind kind = api::BodyKind::kGear;
  double mass_kg = 0;
  // gears only [m]
  double disc_radius_m = 0, disc_height_m = 0, peg_radius_m = 0, peg_top_m = 0;
  // trays only: the slab without its pockets, or the box around it [m]
  Eigen::AlignedBox3d slab;
  std::optional<Outline> outline;  ///< of the slab, where it is no box

  /// Whether a point of the tray's plane lies on the slab.
  [[nodiscard]] bool covers(const Eigen::Vector2d& p_P) const;

  [[nodiscard]] bool is_gear() const { return kind == api::BodyKind::kGear; }
};

/// Gears and trays as a cell numbers them: trays first, then gears.
[[nodiscard]] std::vector<FreeBody> free_bodies_of(const Scene& scene);

/// True if a gear's origin is over a tray's slab and within 5 mm of its top face.
[[nodiscard]] bool stands_on(const Eigen::Isometry3d& X_WG, const Eigen::Isometry3d& X_WP,
                             const FreeBody& tray);

}  // namespace aprsim::scene
