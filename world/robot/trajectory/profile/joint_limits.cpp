#include "world/robot/trajectory/profile/joint_limits.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::robot {
namespace {

constexpr int kPostures = 400;
constexpr double kShortestRunUp_s = 0.2;
constexpr double kLeastTorqueForMotion = 0.1;  ///< of the maximal torque, if gravity needs the rest

/// Quasi-random postures over the joint ranges: the R sequence of Roberts 2018, an additive
/// recurrence with the generalised golden ratio; the same on every run.
JointVector spread_posture(const ArmModel& model, int number) {
  const int n = model.dof();
  // The positive root of x^(n+1) = x + 1, by fixed-point iteration.
  double ratio = 2;
  for (int i = 0; i < 40; ++i) ratio = std::pow(1 + ratio, 1.0 / (n + 1));
  JointVector q(n);
  double step = 1;
  for (int i = 0; i < n; ++i) {
    step /= ratio;
    const double share = std::fmod(0.5 + step * (number + 1), 1.0);
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    q(i) = joint.lower_rad + share * (joint.upper_rad - joint.lower_rad);
  }
  return q;
}

}  // namespace

JointLimits derive_joint_limits(const ArmModel& model, const Payload& payload,
                                const Eigen::Vector3d& gravity_B) {
  // Largest axis inertia and gravity torque over the joint ranges.
  const int n = model.dof();
  const JointVector rest = JointVector::Zero(n);
  JointVector inertia = rest, gravity = rest;
  for (int k = 0; k < kPostures; ++k) {
    const JointVector q = spread_posture(model, k);
    // Worst cases are taken separately, which is conservative: the limits hold in every posture.
    inertia = inertia.cwiseMax(mass_matrix(model, payload, q).diagonal());
    const JointVector hold = inverse_dynamics(model, payload, gravity_B, q, rest, rest);
    gravity = gravity.cwiseMax(hold.cwiseAbs());
  }
  JointLimits limits{rest, rest, rest, rest, rest};
  for (int i = 0; i < n; ++i) {
    const Joint& joint = model.joints[static_cast<std::size_t>(i)];
    limits.lower(i) = joint.lower_rad;
    limits.upper(i) = joint.upper_rad;
    limits.speed(i) = joint.max_speed_rad_s;
    // The torque beyond gravity accelerates the axis.
    const double torque = std::max(kTorqueShare * joint.max_torque_nm - gravity(i),
                                   kLeastTorqueForMotion * joint.max_torque_nm);
    limits.accel(i) = joint.max_speed_rad_s / kShortestRunUp_s;
    if (inertia(i) > 0) limits.accel(i) = std::min(limits.accel(i), torque / inertia(i));
    limits.jerk(i) = limits.accel(i) / kJerkTime_s;
  }
  return limits;
}

}  // namespace aprsim::robot
