#pragma once

#include <memory>

#include "world/robot/kinematics/inverse_kinematics.hpp"

/// Closed forms of arms with seven and four joints in whatever frames they are described. Null
/// where the arm is not of the family.
namespace aprsim::robot {

/// Axes 1 to 3 meeting in a point, consecutive axes orthogonal, and either axes 5 to 7 meeting in a
/// point and axis 4 meeting axes 3 and 5 (S-R-S), or axes 5 and 6 meeting (as Franka's arms).
[[nodiscard]] std::unique_ptr<InverseKinematics> fit_seven_axes(const ArmModel& model);

/// Three revolute joints and one prismatic one, in any order, all along one direction.
[[nodiscard]] std::unique_ptr<InverseKinematics> fit_scara(const ArmModel& model);

}  // namespace aprsim::robot
