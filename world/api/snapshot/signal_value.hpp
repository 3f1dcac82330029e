#pragma once

#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/api/values/guard.hpp"

namespace aprsim::api {

namespace detail {
[[nodiscard]] inline double measured(const Signal& signal, const RobotSnapshot& robot) {
  const auto i = static_cast<std::size_t>(signal.index);
  const auto axis = [&](const Eigen::Vector3d& v) { return i < 3 ? v[signal.index] : 0; };
  switch (signal.kind) {
    case SignalKind::kForceR:
      return axis(robot.force_T_R);
    case SignalKind::kTorqueR:
      return axis(robot.torque_T_R);
    case SignalKind::kForceT:
      return axis(robot.X_RT.q.inverse() * robot.force_T_R);
    case SignalKind::kTorqueT:
      return axis(robot.X_RT.q.inverse() * robot.torque_T_R);
    case SignalKind::kJointTorque:
      return i < robot.joints.size() ? robot.joints[i].torque_nm : 0;
    case SignalKind::kGripForce:
      return i < robot.gripper.force_n.size() ? robot.gripper.force_n[i] : 0;
    case SignalKind::kSeparation:
      return robot.gripper.separation_m;
    case SignalKind::kPartPresent:
      return robot.gripper.holding ? 1 : 0;
    case SignalKind::kLightCurtain:
      break;
  }
  return robot.light_curtain_broken ? 1 : 0;
}
}  // namespace detail

/// The value of `signal` in this snapshot of a robot, SI. An index that does not exist reads 0.
[[nodiscard]] inline double value_of(const Signal& signal, const RobotSnapshot& robot) {
  const double value = detail::measured(signal, robot);
  return signal.reversed ? -value : value;
}

}  // namespace aprsim::api
