#pragma once

#include "protocols/web/topics/visual_description.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// Shapes of a scene that only its picture needs, in addition to the cell's description.
[[nodiscard]] web::VisualDescription visual_of(const scene::Scene& scene);

}  // namespace aprsim::server
