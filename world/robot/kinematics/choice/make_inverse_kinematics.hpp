#pragma once

#include <memory>

#include "world/robot/kinematics/inverse_kinematics.hpp"

namespace aprsim::robot {

/// Picks the solver by the arm's geometry, whatever frames describe it. In closed form: six axes
/// with a spherical wrist or with parallel axes 2 to 4, seven axes with spherical shoulder and
/// wrist or as Franka's, SCARAs. Numeric: all others of 4 to 7 joints. A model with another number
/// of joints is kUnimplemented.
[[nodiscard]] Result<std::unique_ptr<InverseKinematics>> make_inverse_kinematics(
    const ArmModel& model);

}  // namespace aprsim::robot
