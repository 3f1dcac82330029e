#pragma once

#include <algorithm>
#include <array>

#include "world/base/simd/vec8f.hpp"
#include "world/render/mesh/aruco.hpp"
#include "world/render/mesh/material.hpp"

namespace aprsim::render {

/// Distance from the nearest multiple of `pitch`.
inline Vec8f off_multiple(const Vec8f& x, float pitch) {
  return abs(x - pitch * round(x * (1 / pitch)));
}

/// A marker's cells, row by row from the top: whether each has the second colour.
using MarkerCells = std::array<bool, kMarkerCells * kMarkerCells>;

inline MarkerCells marker_cells(const Material& material) {
  MarkerCells cells{};
  for (int i = 0; i < kMarkerCells * kMarkerCells; ++i) {
    cells[static_cast<std::size_t>(i)] =
        material.pattern == Pattern::kMarker &&
        !marker_is_white(material.marker, i / kMarkerCells, i % kMarkerCells);
  }
  return cells;
}

/// Whether eight points of a surface have the second colour of its material. `x`, `y`: in the
/// mesh's x-y plane [m]; `phase_m`: of a moving pattern along x.
inline Mask8 has_second(const Material& material, const MarkerCells& cells, const Vec8f& x,
                        const Vec8f& y, float phase_m) {
  constexpr float kHolePitch_m = 0.0254F, kHoleRadius_m = 0.0032F;
  constexpr float kStripePitch_m = 0.24F, kStripe_m = 0.02F;
  constexpr float kGrid_m = 1, kLine_m = 0.01F;
  switch (material.pattern) {
    case Pattern::kPlain:
      break;
    case Pattern::kMarker: {
      // The first row is the one at +y.
      const float per_m = kMarkerCells / material.marker_size_m;
      const Vec8f across = (x - material.marker_centre.x()) * per_m + 0.5F * kMarkerCells;
      const Vec8f down = 0.5F * kMarkerCells - (y - material.marker_centre.y()) * per_m;
      const Mask8 inside =
          (across >= 0) & (down >= 0) & (across < kMarkerCells) & (down < kMarkerCells);
      if (!any(inside)) break;
      const Vec8i place =
          clamp(truncate(clamp(down, 0, kMarkerCells)), 0, kMarkerCells - 1) * kMarkerCells +
          clamp(truncate(clamp(across, 0, kMarkerCells)), 0, kMarkerCells - 1);
      Mask8 out;
      for (int lane = 0; lane < kLanes; ++lane) {
        out[lane] = cells[static_cast<std::size_t>(place[lane])] ? -1 : 0;
      }
      return out & inside;
    }
    case Pattern::kHoles: {
      const Vec8f off_x = off_multiple(x, kHolePitch_m), off_y = off_multiple(y, kHolePitch_m);
      return off_x * off_x + off_y * off_y < broadcast(kHoleRadius_m * kHoleRadius_m);
    }
    case Pattern::kBelt:
      return off_multiple(x - phase_m, kStripePitch_m) < broadcast(kStripe_m);
    case Pattern::kGrid:
      return min(off_multiple(x, kGrid_m), off_multiple(y, kGrid_m)) < broadcast(kLine_m);
  }
  return broadcast(0);
}

}  // namespace aprsim::render
