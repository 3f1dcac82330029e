#pragma once

#include <map>
#include <string>

#include "world/base/result.hpp"

namespace aprsim::robot {

/// Reflected rotor inertia [kg m^2] by joint name: gear_ratio^2 * rotor_inertia, from the
/// `<transmission><actuator>` elements `drake:gear_ratio` and `drake:rotor_inertia` of a URDF
/// file (the names that Drake's parser gave them; the URDF reader itself skips them). A joint
/// without a transmission is absent. Errors name the file, the element and its line.
[[nodiscard]] Result<std::map<std::string, double>> read_reflected_inertias(
    const std::string& urdf_path);

}  // namespace aprsim::robot
