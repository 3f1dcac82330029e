#include "world/robot/arm.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <utility>

#include <Eigen/Cholesky>

namespace aprsim::robot {
namespace {

constexpr double kSettledAngle = 1e-9;  ///< a deviation below both of these is set to zero [rad]
constexpr double kSettledSpeed = 1e-7;  ///< [rad/s]
constexpr double kReturnSpeed = 0.5;    ///< of the joint's greatest speed
constexpr double kReturnTorque = 0.3;   ///< of the joint's torque, for braking on the way back
constexpr double kIntegralDecay = 0.9;  ///< per step while saturated
constexpr int kTripSteps = 2;           ///< one sample may be noise
constexpr std::size_t kReasonCapacity = 160;

}  // namespace

Arm::Arm(ArmModel model, Payload payload, const Eigen::Vector3d& gravity_B,
         const JointVector& q_start, double step_s, ServoParameters servo)
    : model_(std::move(model)),
      payload_(std::move(payload)),
      gravity_B_(gravity_B),
      step_s_(step_s),
      servo_(servo),
      max_torque_(model_.dof()),
      max_speed_(model_.dof()),
      q_ref_(q_start),
      q_(q_start) {
  const int n = model_.dof();
  assert(q_start.size() == n && step_s > 0);
  for (int i = 0; i < n; ++i) {
    max_torque_(i) = model_.joints[static_cast<std::size_t>(i)].max_torque_nm;
    max_speed_(i) = model_.joints[static_cast<std::size_t>(i)].max_speed_rad_s;
  }
  qd_ref_ = e_ = ed_ = integral_ = qd_ = JointVector::Zero(n);
  torque_ = inverse_dynamics(model_, payload_, gravity_B_, q_, qd_, qd_);
  trip_reason_.reserve(kReasonCapacity);
}

void Arm::step(const JointVector& q_ref_next, const JointVector& tau_ext) {
  assert(q_ref_next.size() == model_.dof() && tau_ext.size() == model_.dof());
  // Velocity and acceleration as this step realises them: a feedforward from them leaves no
  // tracking error.
  const JointVector qd_ref_next = (q_ref_next - q_ref_) / step_s_;
  const JointVector qdd_ref = (qd_ref_next - qd_ref_) / step_s_;
  const JointVector feedforward =
      inverse_dynamics(model_, payload_, gravity_B_, q_ref_, qd_ref_next, qdd_ref);
  const JointVector disturbance = beyond_friction(tau_ext);
  const bool overloaded = (feedforward.array().abs() > max_torque_.array()).any();
  const bool disturbed = (disturbance.array() != 0).any();

  if (deviating_ || overloaded || disturbed) {
    deviate(feedforward, disturbance);
    watch(feedforward);
    const bool settled = !overloaded && !disturbed && (e_.array().abs() < kSettledAngle).all() &&
                         (ed_.array().abs() < kSettledSpeed).all();
    deviating_ = !settled;
    if (settled) e_ = ed_ = integral_ = JointVector::Zero(model_.dof());
  } else {
    torque_ = feedforward;
  }
  q_ref_ = q_ref_next;
  qd_ref_ = qd_ref_next;
  if (deviating_) {
    q_ = q_ref_ + e_;
    qd_ = qd_ref_ + ed_;
  } else {
    q_ = q_ref_;
    qd_ = qd_ref_;
    disturbed_steps_ = 0;
  }
}

/// What is left of the external torque after the joints' friction has taken its share.
JointVector Arm::beyond_friction(const JointVector& tau_ext) const {
  JointVector out(model_.dof());
  for (int i = 0; i < model_.dof(); ++i) {
    const double friction = servo_.friction_fraction * max_torque_(i);
    const double excess = std::abs(tau_ext(i)) - friction;
    out(i) = excess > 0 ? std::copysign(excess, tau_ext(i)) : 0.0;
  }
  return out;
}

/// Speed with which each joint should return to its reference: proportional close to it, braking
/// with a share of the torque from farther away, so that a saturated joint cannot overshoot for
/// ever.
JointVector Arm::return_speed(const JointMatrix& H) const {
  JointVector out(model_.dof());
  for (int i = 0; i < model_.dof(); ++i) {
    const double distance = std::abs(e_(i));
    const double braking = kReturnTorque * max_torque_(i) / H(i, i);
    const double knee = braking / servo_.position_gain_1_s;
    const double speed =
        std::min({servo_.position_gain_1_s * distance, kReturnSpeed * max_speed_(i),
                  std::sqrt(knee * knee + 2 * braking * distance)});
    out(i) = -std::copysign(speed, e_(i));
  }
  return out;
}

/// One semi-implicit step of the deviation under servo, torque limits and disturbance.
void Arm::deviate(const JointVector& feedforward, const JointVector& disturbance) {
  const JointMatrix H = robot::mass_matrix(model_, payload_, q_ref_ + e_);
  const JointVector wanted = return_speed(H);
  const JointVector u =
      servo_.velocity_gain_1_s * (wanted - ed_ - servo_.integral_gain_1_s * integral_);
  const JointVector demanded = feedforward + H * u;
  torque_ = demanded.cwiseMax(-max_torque_).cwiseMin(max_torque_);
  const JointVector net = torque_ - feedforward + disturbance;
  ed_ += step_s_ * H.llt().solve(net);
  e_ += step_s_ * ed_;
  for (int i = 0; i < model_.dof(); ++i) {
    if (demanded(i) == torque_(i)) {
      integral_(i) += step_s_ * (ed_(i) - wanted(i));
    } else {
      integral_(i) *= kIntegralDecay;
    }
  }
}

/// Trip conditions: a drive works against something, or the arm is not where it should be.
void Arm::watch(const JointVector& feedforward) {
  // A feedforward beyond the limit is the plan's fault and shows as deviation, not as disturbance.
  const JointVector planned = feedforward.cwiseMax(-max_torque_).cwiseMin(max_torque_);
  const JointVector share = (torque_ - planned).cwiseAbs().cwiseQuotient(max_torque_);
  Eigen::Index worst = 0;
  const bool disturbed = share.maxCoeff(&worst) > servo_.trip_fraction;
  disturbed_steps_ = disturbed ? disturbed_steps_ + 1 : 0;
  if (!trip_reason_.empty()) return;
  if (disturbed_steps_ >= kTripSteps) {
    trip(static_cast<int>(worst), "disturbance torque", share(worst) * max_torque_(worst),
         servo_.trip_fraction * max_torque_(worst), "Nm");
    return;
  }
  const double deviation = e_.cwiseAbs().maxCoeff(&worst);
  if (deviation > servo_.trip_deviation_rad) {
    trip(static_cast<int>(worst), "deviation from the reference", deviation,
         servo_.trip_deviation_rad, "rad");
  }
}

void Arm::trip(int joint, const char* what, double value, double limit, const char* unit) {
  char text[kReasonCapacity];
  std::snprintf(text, sizeof text, "%s: %s %.3g %s, limit %.3g %s",
                model_.joints[static_cast<std::size_t>(joint)].name.c_str(), what, value, unit,
                limit, unit);
  trip_reason_.assign(text);  // within the capacity reserved at construction
}

void Arm::relax() {
  q_ref_ = q_;
  qd_ref_ = qd_;
  e_ = ed_ = integral_ = JointVector::Zero(model_.dof());
  deviating_ = false;
  disturbed_steps_ = 0;
  trip_reason_.clear();
}

void Arm::set_payload(const Payload& payload) { payload_ = payload; }

JointMatrix Arm::mass_matrix() const { return robot::mass_matrix(model_, payload_, q_); }

}  // namespace aprsim::robot
