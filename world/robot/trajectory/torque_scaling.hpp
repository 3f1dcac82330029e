#pragma once

#include <functional>

#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {

/// How much a planned motion must be slowed so that no drive needs more than kTorqueShare of its
/// maximal torque: 1 when it need not, else the factor on its speeds (its square on the
/// accelerations). `position` gives the joints at a time in 0..duration. Samples the motion at
/// fixed shares of its duration. Thread: sim, when a motion is planned.
[[nodiscard]] double torque_pace(const ArmModel& model, const Payload& payload,
                                 const Eigen::Vector3d& gravity_B, double duration_s,
                                 const std::function<JointVector(double)>& position);

}  // namespace aprsim::robot
