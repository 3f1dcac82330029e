#pragma once

#include <algorithm>
#include <cmath>

#include "world/scene/model/scene.hpp"

namespace aprsim::physics::detail {

/// A pocket in the tray frame as its half profile: floor, wall cone, mouth chamfer cone. The wall
/// runs from floor_radius at -depth towards top_radius at z = 0; the chamfer starts where the wall
/// passes z = -chamfer and widens to the mouth. z is measured from the tray's top face.
struct PocketProfile {
  double x = 0, y = 0;
  double depth = 0, r_floor = 0;
  double z_edge = 0, r_edge = 0;  ///< where wall and chamfer meet (0 and the mouth without one)
  double r_mouth = 0;
  double wall_slope = 0, wall_cos = 1;        ///< dr/dz
  double chamfer_slope = 0, chamfer_cos = 1;  ///< dr/dz

  PocketProfile() = default;
  explicit PocketProfile(const scene::Slot& slot)
      : x(slot.xy.x()),
        y(slot.xy.y()),
        depth(slot.pocket.depth_m),
        r_floor(slot.pocket.floor_radius_m),
        z_edge(-slot.pocket.chamfer_m),
        r_edge(slot.pocket.top_radius_m),
        r_mouth(slot.pocket.top_radius_m) {
    if (slot.pocket.top_radius_m != r_floor) {
      wall_slope = (slot.pocket.top_radius_m - r_floor) / depth;
      wall_cos = 1 / std::sqrt(1 + wall_slope * wall_slope);
    }
    chamfer_slope = wall_slope;
    chamfer_cos = wall_cos;
    if (slot.pocket.chamfer_m > 0) {
      r_edge += wall_slope * z_edge;
      chamfer_slope = std::tan(slot.pocket.chamfer_angle_rad);
      chamfer_cos = std::cos(slot.pocket.chamfer_angle_rad);
      r_mouth = r_edge - chamfer_slope * z_edge;
    }
  }

  [[nodiscard]] bool chamfered() const { return z_edge < 0; }
  [[nodiscard]] double r_wall(double z) const { return r_floor + wall_slope * (z + depth); }
  /// How deep (r, z) lies behind the wall's and the chamfer's cone: positive in the tray's
  /// material, below the top face and above the floor.
  [[nodiscard]] double behind_wall(double r, double z) const { return (r - r_wall(z)) * wall_cos; }
  [[nodiscard]] double behind_chamfer(double r, double z) const {
    return (r - r_mouth - chamfer_slope * z) * chamfer_cos;
  }
  [[nodiscard]] double behind_side(double r, double z) const {
    return std::min(behind_wall(r, z), behind_chamfer(r, z));
  }
};

}  // namespace aprsim::physics::detail
