#pragma once

#include <memory>

#include "world/robot/kinematics/inverse_kinematics.hpp"

/// Closed forms of six-axis arms in whatever frames they are described. Null where the arm is not
/// of the family.
namespace aprsim::robot {

/// Axes 2 and 3 parallel and orthogonal to axis 1, axes 4 to 6 meeting in a point and orthogonal.
[[nodiscard]] std::unique_ptr<InverseKinematics> fit_spherical_wrist(const ArmModel& model);

/// Axes 2 to 4 parallel and orthogonal to axis 1, axes 5 and 6 meeting and orthogonal.
[[nodiscard]] std::unique_ptr<InverseKinematics> fit_offset_wrist(const ArmModel& model);

}  // namespace aprsim::robot
