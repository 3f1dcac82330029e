#pragma once

#include <string>
#include <vector>

namespace aprsim::devices {

/// Names of the things that devices refer to, in the order of their indices.
struct CellNames {
  std::vector<std::string> bodies, robots, photo_eyes;
  bool has_belt = false;
};

}  // namespace aprsim::devices
