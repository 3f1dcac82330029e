#include "world/sensors/light_curtain.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace aprsim::sensors {

LightCurtain::LightCurtain(const api::LightCurtainDescription& curtain)
    : curtain_(curtain), X_WK_(curtain.X_WK.isometry()), X_KW_(X_WK_.inverse()) {}

api::LightCurtainSnapshot LightCurtain::measure(std::span<const Occluder> occluders) const {
  api::LightCurtainSnapshot out;
  const auto beams = out.distance_m.begin();
  std::fill_n(beams, curtain_.beams, curtain_.range_m);
  for (const Occluder& occluder : occluders) {
    // Most occluders are nowhere near the plane of the beams.
    const Eigen::Vector3d p_K = X_KW_ * occluder.X_WS.translation();
    const double bound = occluder.bound_m;
    if (std::abs(p_K.y()) > bound || p_K.x() < -bound || p_K.x() > curtain_.range_m + bound) {
      continue;
    }
    const double last_beam = curtain_.beams - 1;
    const double low = std::max(std::ceil((p_K.z() - bound) / curtain_.pitch_m), 0.0);
    const double high = std::min(std::floor((p_K.z() + bound) / curtain_.pitch_m), last_beam);
    for (double beam = low; beam <= high; ++beam) {
      const double z = beam * curtain_.pitch_m;
      const auto hit = first_hit(occluder, X_WK_ * Eigen::Vector3d(0, 0, z),
                                 X_WK_ * Eigen::Vector3d(curtain_.range_m, 0, z));
      if (!hit) continue;
      out.broken = true;
      double& nearest = out.distance_m[static_cast<std::size_t>(beam)];
      nearest = std::min(nearest, *hit * curtain_.range_m);
    }
  }
  return out;
}

}  // namespace aprsim::sensors
