#pragma once

#include <functional>

#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {

/// The time scale of a planned motion with which no drive needs more than kTorqueShare of its
/// maximal torque: the factor on its speeds (its square on the accelerations), 1 where it need not
/// be slowed. `position` gives the joints at a time in 0..duration, and is sampled at fixed shares
/// of the duration. Thread: sim, when a motion is planned.
[[nodiscard]] double torque_scaling(const ArmModel& model, const Payload& payload,
                                    const Eigen::Vector3d& gravity_B, double duration_s,
                                    const std::function<JointVector(double)>& position);

}  // namespace aprsim::robot
