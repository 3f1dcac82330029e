#pragma once

#include <optional>

#include "world/api/faults/fault.hpp"
#include "world/scene/model/camera.hpp"

namespace aprsim::render {

/// A camera with the injected faults that last (null = none); nullopt while it takes no pictures.
[[nodiscard]] std::optional<scene::Camera> with_faults(scene::Camera camera,
                                                       const api::InjectedFaults* faults);

}  // namespace aprsim::render
