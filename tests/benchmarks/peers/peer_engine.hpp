#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/benchmarks/trays/tray_simulation.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// One way to set an engine up. The scene must outlive the simulation.
struct PeerSettings {
  std::string name;
  std::function<std::unique_ptr<TraySimulation>(const scene::Scene&)> make;
};

/// Another engine, which the Table 1 scene runs in too.
struct PeerEngine {
  std::string name, short_name, version;
  std::vector<PeerSettings> settings;
};

/// The engines of the CMake variable APRSIM_PEERS; none is a list too.
std::vector<PeerEngine> peer_engines();

}  // namespace aprsim::bench
