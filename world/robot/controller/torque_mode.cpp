#include "world/robot/controller/torque_mode.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::robot {
namespace {

constexpr double kSpeedShare = 0.25, kAccelShare = 0.5;  ///< of the joint's limits
/// The load is at most as stiff as the joint's servo: position gain times velocity gain times
/// inertia. The torque may change by this share of the setting in a step, so that it settles.
constexpr double kServoStiffness_1_s2 = 12000;
constexpr double kTorqueStep = 0.1;
constexpr double kBalance = 0.05;       ///< of the setting
constexpr double kBalanceSpeed = 0.05;  ///< of the free speed
constexpr double kBalanceTime_s = 0.1;

}  // namespace

void TorqueMode::add(const Setpoint& setpoint, double position_rad) {
  DrivenJoint& joint = joints_[static_cast<std::size_t>(count_++)];
  joint = {setpoint,
           position_rad,
           0,
           setpoint.rate_nm_s > 0 ? 0.0 : setpoint.torque_nm,
           position_rad == setpoint.target_rad,
           0};
}

bool TorqueMode::settled() const {
  return std::all_of(joints_.begin(), joints_.begin() + count_, [](const DrivenJoint& joint) {
    return joint.at_target || joint.balanced_steps == kBalanceReported;
  });
}

int TorqueMode::balanced_joint() const {
  for (int i = 0; i < count_; ++i) {
    const DrivenJoint& joint = joints_[static_cast<std::size_t>(i)];
    if (!joint.at_target) return joint.setpoint.joint;
  }
  return -1;
}

void TorqueMode::advance(const StepInput& input, JointVector& q) {
  for (int i = 0; i < count_; ++i) {
    DrivenJoint& joint = joints_[static_cast<std::size_t>(i)];
    if (!joint.at_target) advance(joint, input);
    q(joint.setpoint.joint) = joint.position;
  }
}

/// Admittance control: the speed is proportional to the difference of applied and load torque.
void TorqueMode::advance(DrivenJoint& joint, const StepInput& input) const {
  const int j = joint.setpoint.joint;
  const double dt = input.step_s;
  const double setting = joint.setpoint.torque_nm;
  // Applied torque, ramped up, and load torque against it.
  joint.torque = std::min(setting, joint.torque + joint.setpoint.rate_nm_s * dt);
  const double distance = joint.setpoint.target_rad - joint.position;
  const double side = distance > 0 ? 1 : -1;
  const double load = input.external_nm.size() > 0 ? -side * input.external_nm(j) : 0.0;
  // Admittance law.
  // The load is at most as stiff as its servo, k = kp kv H. A step at this speed changes the torque
  // by a tenth of the setting, so that the discrete loop is stable (Colgate & Hogan 1988 on coupled
  // stability).
  const double free_speed =
      input.speed *
      std::min(kSpeedShare * input.limits.speed(j),
               kTorqueStep * setting / (kServoStiffness_1_s2 * input.inertia(j) * dt));
  const double wanted = free_speed * std::clamp((joint.torque - load) / setting, -1.0, 1.0);
  // Towards the target: accelerates with no more than the torque, decelerates as fast as the joint
  // may, and in time for the target.
  const double accel = std::min(kAccelShare * input.limits.accel(j), setting / input.inertia(j));
  const double before = side * joint.speed;
  const double speed =
      std::min(std::clamp(wanted, before - input.limits.accel(j) * dt, before + accel * dt),
               // v^2 = 2 a s: the highest speed from which the joint can still stop at the target.
               std::sqrt(2 * accel * std::abs(distance)));
  joint.speed = side * speed;
  joint.position += joint.speed * dt;
  if (side * (joint.setpoint.target_rad - joint.position) <= 0) {
    joint.position = joint.setpoint.target_rad;
    joint.speed = 0;
    joint.at_target = true;
  }
  // Balance of applied and load torque, reported once.
  if (joint.balanced_steps == kBalanceReported) return;
  const bool balanced = joint.torque == setting && free_speed > 0 &&
                        std::abs(load - setting) < kBalance * setting &&
                        std::abs(speed) < kBalanceSpeed * free_speed;
  joint.balanced_steps = balanced ? joint.balanced_steps + 1 : 0;
  if (joint.balanced_steps * dt >= kBalanceTime_s) joint.balanced_steps = kBalanceReported;
}

JointVector TorqueMode::applied_torque(int dof) const {
  JointVector torque = JointVector::Zero(dof);
  for (int i = 0; i < count_; ++i) {
    const DrivenJoint& joint = joints_[static_cast<std::size_t>(i)];
    if (!joint.at_target) torque(joint.setpoint.joint) = joint.torque;
  }
  return torque;
}

}  // namespace aprsim::robot
