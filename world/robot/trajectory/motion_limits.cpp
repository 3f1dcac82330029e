#include "world/robot/trajectory/motion_limits.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

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

constexpr int kTorqueSamples = 48;
constexpr double kTorqueDifference_s = 1e-3;
constexpr double kSlowestScale = 0.1;

constexpr std::array kAll{api::MotionLimit::kTransSpeed, api::MotionLimit::kTransAccel,
                          api::MotionLimit::kRotSpeed, api::MotionLimit::kRotAccel};
/// In the order of kAll [m/s, m/s^2, rad/s, rad/s^2].
constexpr std::array kAtStart{0.25, 2.0, 1.0, 5.0};

/// For messages.
const char* name_of(api::MotionLimit which) {
  switch (which) {
    case api::MotionLimit::kTransSpeed:
      return "translation speed";
    case api::MotionLimit::kTransAccel:
      return "translation acceleration";
    case api::MotionLimit::kRotSpeed:
      return "rotation speed";
    case api::MotionLimit::kRotAccel:
      return "rotation acceleration";
  }
  throw std::logic_error("unknown motion limit");
}

/// One of the four limits.
double part(const ToolLimits& limits, api::MotionLimit which) {
  switch (which) {
    case api::MotionLimit::kTransSpeed:
      return limits.trans_speed_m_s;
    case api::MotionLimit::kTransAccel:
      return limits.trans_accel_m_s2;
    case api::MotionLimit::kRotSpeed:
      return limits.rot_speed_rad_s;
    case api::MotionLimit::kRotAccel:
      return limits.rot_accel_rad_s2;
  }
  throw std::logic_error("unknown motion limit");
}

std::size_t index(api::MotionLimit which) { return static_cast<std::size_t>(which); }

}  // namespace

JointLimits derive_joint_limits(const ArmModel& model, const Payload& payload,
                                const Eigen::Vector3d& gravity_B) {
  // Largest axis inertia and gravity torque over the joint ranges.
  const int n = model.dof();
  const JointVector rest = JointVector::Zero(n);
  JointVector inertia = rest, gravity = rest;
  for (int k = 0; k < kPostures; ++k) {
    const JointVector q = spread_posture(model, k);
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

// Dynamic scaling: Hollerbach 1984. The torques of a motion slowed by the factor c are those that
// hold the arm plus c^2 times those that motion adds. Deviation: one factor for the whole motion.
double torque_scaling(const ArmModel& model, const Payload& payload,
                      const Eigen::Vector3d& gravity_B, double duration_s,
                      const std::function<JointVector(double)>& position) {
  const JointVector rest = JointVector::Zero(model.dof());
  double square = 1;  // of the scale
  for (int k = 0; k < kTorqueSamples; ++k) {
    const double t = duration_s * (k + 0.5) / kTorqueSamples;
    const double h = std::min(kTorqueDifference_s, duration_s / (2 * kTorqueSamples));
    if (!(h > 0)) return 1;
    // Central differences.
    const JointVector before = position(t - h), q = position(t), after = position(t + h);
    const JointVector qd = (after - before) / (2 * h);
    const JointVector qdd = (after - 2 * q + before) / (h * h);
    // Torques that hold the arm, and that motion adds.
    const JointVector hold = inverse_dynamics(model, payload, gravity_B, q, rest, rest);
    const JointVector moving = inverse_dynamics(model, payload, gravity_B, q, qd, qdd) - hold;
    // The scale that leaves the worst drive its share.
    for (int i = 0; i < model.dof(); ++i) {
      const double limit = kTorqueShare * model.joints[static_cast<std::size_t>(i)].max_torque_nm;
      const double room = limit - std::copysign(1.0, moving(i)) * hold(i);
      if (std::abs(moving(i)) * square > room) square = room / std::abs(moving(i));
    }
  }
  return std::sqrt(std::clamp(square, kSlowestScale * kSlowestScale, 1.0));
}

ToolLimitSettings::ToolLimitSettings(const ToolLimits& maximum) : maximum_(maximum) {
  for (const auto which : kAll) {
    const double highest = part(maximum, which);
    if (!(highest > 0) || !std::isfinite(highest)) {
      throw std::invalid_argument(std::string("the robot's maximal ") + name_of(which) +
                                  " must be > 0");
    }
    settings_[index(which)] = {false, std::min(highest, kAtStart[index(which)])};
  }
}

/// A fraction refers to the maximum and stays a fraction.
void ToolLimitSettings::set(const api::SetMotionLimit& setting) {
  const double value =
      setting.relative ? setting.value : std::min(setting.value, part(maximum_, setting.which));
  settings_[index(setting.which)] = {setting.relative, value};
}

api::LimitSetting ToolLimitSettings::get(api::MotionLimit which) const {
  return settings_[index(which)];
}

double ToolLimitSettings::value(api::MotionLimit which,
                                const std::optional<api::LimitSetting>& own) const {
  const api::LimitSetting setting = own.value_or(settings_[index(which)]);
  const double highest = part(maximum_, which);
  return std::min(highest, setting.relative ? setting.value * highest : setting.value);
}

ToolLimits ToolLimitSettings::effective() const { return effective({}); }

ToolLimits ToolLimitSettings::effective(const api::PoseLimits& own) const {
  return {value(api::MotionLimit::kTransSpeed, own.trans_speed),
          value(api::MotionLimit::kTransAccel, own.trans_accel),
          value(api::MotionLimit::kRotSpeed, own.rot_speed),
          value(api::MotionLimit::kRotAccel, own.rot_accel)};
}

}  // namespace aprsim::robot
