#pragma once

#include <string>
#include <vector>

namespace aprsim::world {

/// The libraries whose asserts this build executes: "aprsim" (assert), "Eigen" (sizes and indices),
/// "ODE". Broken invariants that are checked otherwise throw in every build.
[[nodiscard]] std::vector<std::string> kept_asserts();

}  // namespace aprsim::world
