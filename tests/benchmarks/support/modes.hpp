#pragma once

#include <array>
#include <string>

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// A contact simplification mode and its name in scene files.
struct Mode {
  const char* name;
  scene::Simplification value;
};

inline constexpr std::array kModes = {Mode{"off", scene::Simplification::kOff},
                                      Mode{"virtual_joints", scene::Simplification::kVirtualJoints},
                                      Mode{"merge", scene::Simplification::kMerge},
                                      Mode{"dormant", scene::Simplification::kDormant}};

/// Mode of the shipped scenes.
inline constexpr Mode kDefaultMode = kModes.back();

}  // namespace aprsim::bench
