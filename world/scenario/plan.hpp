#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "world/base/result.hpp"
#include "world/scenario/scenario.hpp"
#include "world/scene/data_paths.hpp"

namespace aprsim::scenario {

/// One run of a scenario. Everything that varies is drawn; the cell draws its noise from the seed.
struct Plan {
  std::uint64_t seed = 1;
  std::string scene_text;       ///< complete scene file; it refers to robot models only
  scene::Scene scene;           ///< read from scene_text
  std::vector<Fault> faults;    ///< both ends of at_s are equal
  std::vector<double> kills_s;  ///< times of killing the controller, rising
  /// Drawn values by name and unit: "kit_1.x_m" is the offset from the pose in the scene.
  std::map<std::string, double> drawn;
};

/// Draws the variation of a run. A pure function: the same arguments give the same bits everywhere.
/// Each value has its own random stream, so adding or removing one leaves the others unchanged.
/// Scenes with overlapping trays are drawn again. Error: none of 100 draws is valid.
[[nodiscard]] Result<Plan> plan(const Scenario& scenario, std::uint64_t seed,
                                const scene::DataPaths& paths);

}  // namespace aprsim::scenario
