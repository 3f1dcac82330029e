#pragma once

#include <cmath>

#include "world/physics/collision/pairs/narrow_phase.hpp"

namespace aprsim::physics {

/// Distance between the face lines of two such pads that hold a centred peg [m]: the fingers must
/// be able to close to less than this.
[[nodiscard]] inline double holding_gap(const Pad& pad, double peg_radius_m) {
  if (pad.shape == scene::PadShape::kFlat) return 2 * peg_radius_m;
  // From the peg's axis to the groove's apex.
  const double to_apex = peg_radius_m / std::sin(pad.v_half_angle_rad);
  return 2 * (to_apex - v_groove_depth(pad, peg_radius_m));
}

}  // namespace aprsim::physics
