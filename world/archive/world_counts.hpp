#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace aprsim::archive {

/// The things that indices in a state refer to.
enum class Of {
  kPart,      ///< gears and trays
  kFreeBody,  ///< parts, then tools
  kBody,      ///< free bodies, then palm, fingers and links of each robot (BodyIds)
  kTool,
  kRobot,
  kFixed,  ///< fixed shapes
  kPhotoEye,
};

[[nodiscard]] constexpr const char* name_of(Of what) {
  constexpr const char* kNames[] = {"parts",  "free bodies",  "bodies",    "tools",
                                    "robots", "fixed shapes", "photo-eyes"};
  return kNames[static_cast<std::size_t>(what)];
}

/// How many of everything a world has: bounds of the indices in its states.
struct WorldCounts {
  struct Robot {
    int joints = 0, links = 0;
  };
  std::vector<Robot> robots;
  int parts = 0, tools = 0, fixed = 0, photo_eyes = 0;
  bool belt = false, light_curtain = false;
  std::vector<bool> bodies;  ///< by the id of a body: whether there is one

  [[nodiscard]] std::int64_t of(Of what) const {
    switch (what) {
      case Of::kPart:
        return parts;
      case Of::kFreeBody:
        return parts + tools;
      case Of::kBody:
        return static_cast<std::int64_t>(bodies.size());
      case Of::kTool:
        return tools;
      case Of::kRobot:
        return static_cast<std::int64_t>(robots.size());
      case Of::kFixed:
        return fixed;
      case Of::kPhotoEye:
        break;
    }
    return photo_eyes;
  }
  [[nodiscard]] bool has(Of what, std::int64_t index) const {
    if (index < 0 || index >= of(what)) return false;
    return what != Of::kBody || bodies[static_cast<std::size_t>(index)];
  }
};

}  // namespace aprsim::archive
