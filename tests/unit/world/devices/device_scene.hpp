#pragma once

#include <memory>
#include <string>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"
#include "world/cell/world.hpp"

namespace aprsim::test {

/// The scene `base` with lines of YAML below its key `devices`. Throws with the reader's error.
std::shared_ptr<const scene::Scene> scene_with(const std::string& devices,
                                               const std::string& base = "empty_belt");

/// A device of the extension mover in one line.
std::string mover(const std::string& name, const std::string& parameters);
/// A device of the extension trouble.
std::string trouble(const std::string& kind, int at_step = 0);
/// A scale over the belt's middle.
std::string scale(const std::string& more = "");

/// A pusher along x over the belt's middle, with up to 10 N.
std::string pusher(const std::string& name = "pusher");

api::Snapshot snapshot_of(const world::World& world);
void advance(world::World& world, int steps);
/// A signal of a device in a snapshot. Throws where there is none.
double signal(const api::Snapshot& now, const std::string& device, const std::string& name);
const std::string& fault(const api::Snapshot& now, const std::string& device);

}  // namespace aprsim::test
