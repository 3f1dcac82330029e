#pragma once

#include <nlohmann/json.hpp>

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// How exactly Jolt solves. Its margins are those of a world a hundred times as large: here they
/// are as tight as what lies in a pocket needs.
struct JoltSettings {
  int velocity_steps = 10, position_steps = 2;  ///< Jolt's own defaults
};

/// A scene as `jolt_native` and `jolt_wasm.mjs` read it, in SI. Bodies in Jolt's order: what is
/// fixed, trays, gears. Trays are boxes around square holes (peers/peer_geometry.hpp), gears a
/// disc, a conical hub and a peg; masses, centres of mass and inertias are the scene's.
nlohmann::json jolt_model(const scene::Scene& scene, const JoltSettings& settings);

}  // namespace aprsim::bench
