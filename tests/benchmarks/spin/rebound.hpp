#pragma once

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// Bodies that fall flat.
enum class Faller { kTrayOnTable, kTrayOnBelt, kGearOnTable };
const char* name_of(Faller faller);

/// The height to which it rises after its first impact, over that from which it fell: e^2.
[[nodiscard]] double rebound(scene::Simplification mode, Faller faller, double restitution,
                             double height_m, double yaw_rad);

}  // namespace aprsim::bench
