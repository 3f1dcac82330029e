#pragma once

#include <memory>

#include "world/physics/engine/engine.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// The engine that a scene chooses.
[[nodiscard]] std::unique_ptr<Engine> make_engine(const scene::Physics& physics);

}  // namespace aprsim::physics
