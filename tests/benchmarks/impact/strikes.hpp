#pragma once

#include <array>
#include <random>
#include <string>

#include "world/scene/model/scene.hpp"

/// Parts that fly into an obstacle at 10 m/s.
namespace aprsim::bench {

enum class Target { kPlate, kTable, kBelt, kTray, kFullTray, kPad, kPart };
inline constexpr std::array kTargets = {Target::kPlate, Target::kTable,    Target::kBelt,
                                        Target::kTray,  Target::kFullTray, Target::kPad,
                                        Target::kPart};
const char* name_of(Target target);

struct Strike {
  double deepest_m = 0;  ///< anything in anything
  bool met = false;      ///< it did not fly on as if there were nothing
  bool passed = false;   ///< it went through: into the table, or on undisturbed
};

/// A part of that type, at any attitude, turning, with its centre of mass on a line through the
/// target's middle and up to 5 mm off.
[[nodiscard]] Strike strike(scene::Simplification mode, Target target, const std::string& type,
                            std::mt19937_64& engine);

}  // namespace aprsim::bench
