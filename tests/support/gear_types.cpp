#include "tests/support/gear_types.hpp"

#include <numbers>

namespace aprsim::physics::test {

scene::GearType gear_type(const std::string& name) {
  scene::GearType type;
  type.name = name;
  type.disc_height_m = 0.006;
  type.hub_height_m = 0.012;
  type.hub_chamfer_m = 0.0003;
  type.peg_radius_m = 0.00385;
  type.peg_top_m = 0.026;
  if (name == "small") {
    type.disc_radius_m = 0.032, type.hub_top_radius_m = 0.022, type.hub_bottom_radius_m = 0.01507;
    type.mass_kg = 0.0102;
  } else if (name == "medium") {
    type.disc_radius_m = 0.04, type.hub_top_radius_m = 0.03, type.hub_bottom_radius_m = 0.02307;
    type.mass_kg = 0.0187;
  } else if (name == "large") {
    type.disc_radius_m = 0.05, type.hub_top_radius_m = 0.04, type.hub_bottom_radius_m = 0.03307;
    type.mass_kg = 0.033;
  } else {
    type.hub_top_radius_m = 0.01, type.hub_bottom_radius_m = 0.01;
    type.hub_height_m = 0.006, type.peg_radius_m = 0.0038, type.peg_top_m = 0.024;
    type.disc_radius_m = name == "d50"    ? 0.025
                         : name == "d70"  ? 0.035
                         : name == "d100" ? 0.05
                                          : 0.03;
    type.mass_kg = name == "d50" ? 0.01 : name == "d100" ? 0.033 : 0.02;
  }
  return type;
}

scene::Pocket pocket_for(const std::string& gear) {
  const scene::GearType type = gear_type(gear);
  if (gear[0] == 'd') return {0.0103, 0.0103, 0.0065, 0.0005, std::numbers::pi / 4};
  const double slope = (type.hub_top_radius_m - type.hub_bottom_radius_m) / type.hub_height_m;
  const double top = type.hub_top_radius_m + 0.0002;
  return {top, top - 0.0125 * slope, 0.0125, 0, std::numbers::pi / 4};
}

}  // namespace aprsim::physics::test
