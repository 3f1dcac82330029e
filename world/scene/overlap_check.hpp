#pragma once

#include "world/scene/model/scene.hpp"
#include "world/scene/readers/object_reader.hpp"

namespace aprsim::scene {

/// Records an error for the first free body that lies more than 0.1 mm deep in something: tray or
/// gear in another, in a fixed box, the belt or the floor. A gear and its own tray are left out.
void check_overlaps(const Scene& scene, const BodyNodes& nodes);

}  // namespace aprsim::scene
