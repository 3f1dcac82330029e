#pragma once

#include <string>

#include "world/scene/model/scene.hpp"

/// Gears and pockets in code, for tests that need no scene file.
namespace aprsim::physics::test {

/// Gears of the 2024 generation (conical hub) named small, medium, large, and with a cylindrical
/// hub 20 x 6 mm and a peg 7.6 x 18 mm: "d50" (10 g), "d60", "d70" (20 g), "d100" (33 g).
scene::GearType gear_type(const std::string& name);

/// The pocket a gear type sits in: cone with 0.2 mm of clearance, or for the others a cylinder with
/// 0.3 mm of clearance and a 0.5 mm mouth chamfer.
scene::Pocket pocket_for(const std::string& gear);

}  // namespace aprsim::physics::test
