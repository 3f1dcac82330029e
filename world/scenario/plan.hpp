#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "world/base/result.hpp"
#include "world/scenario/scenario.hpp"
#include "world/scene/data_paths.hpp"

namespace aprsim::scenario {

/// One run of a scenario, with nothing left to chance but what the cell draws from the same seed.
struct Plan {
  std::uint64_t seed = 1;
  std::string scene_text;       ///< a scene file of its own; found models apart it names no other
  scene::Scene scene;           ///< the same, read
  std::vector<Fault> faults;    ///< each at_s is one time
  std::vector<double> kills_s;  ///< when the controller is killed, in their order
  /// Drawn values, by name with its unit: "kit_1.x_m" is beside where the scene has the tray.
  std::map<std::string, double> drawn;
};

/// Draws what varies. A function of its arguments: the same bits everywhere. A value keeps to its
/// own stream, so that another one more or less changes nothing else. A scene whose trays meet is
/// drawn again. Error: none of 100 draws fits.
[[nodiscard]] Result<Plan> plan(const Scenario& scenario, std::uint64_t seed,
                                const scene::DataPaths& paths);

}  // namespace aprsim::scenario
