#include "world/robot/servo/servo_arm.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <utility>

#include <Eigen/Cholesky>

#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

constexpr double kSettledAngle = 1e-9;  ///< a deviation below both of these is set to zero [rad]
constexpr double kSettledSpeed = 1e-7;  ///< [rad/s]
constexpr double kReturnSpeed = 0.5;    ///< of the joint's greatest speed
constexpr double kReturnTorque = 0.3;   ///< of the joint's torque, for braking on the way back
constexpr double kIntegralDecay = 0.9;  ///< per step while saturated
constexpr int kTripSteps = 2;           ///< one sample may be noise
constexpr std::size_t kReasonCapacity = 160;

/// Push at the tool that trips no joint, and the largest share of a drive's torque for it: the
/// drives of a wrist are weak, and the push of a person's hand must not stop the robot.
constexpr double kBearablePush_n = 60, kMostTripShare = 0.85;
constexpr double kWristReach_m = 0.65;      ///< joints with less of the arm beyond them are wrist
constexpr double kTipBeyondCentre_m = 0.1;  ///< of the gripper, beyond its centre of mass

/// Disturbance torque that trips a joint: its share of the drive's torque; for the wrist at least
/// the torque of the bearable push at the longest lever of the arm beyond the joint.
double trip_torque(const ArmModel& model, const Payload& payload, int joint, double fraction) {
  const double most = model.joints[static_cast<std::size_t>(joint)].max_torque_nm;
  double lever = payload.mass_kg > 0 ? payload.com_F.norm() + kTipBeyondCentre_m : 0.0;
  // Upper bound of the lever: the arm stretched beyond the joint.
  for (std::size_t k = static_cast<std::size_t>(joint) + 1; k < model.joints.size(); ++k) {
    lever += longest_offset(model.joints[k]);
  }
  // No lever makes a force of a force.
  if (model.joints[static_cast<std::size_t>(joint)].prismatic) return fraction * most;
  lever += flange_offset(model);
  if (lever > kWristReach_m) return fraction * most;
  return std::max(fraction * most, std::min(kMostTripShare * most, kBearablePush_n * lever));
}

}  // namespace

ServoArm::ServoArm(ArmModel model, Payload payload, const Eigen::Vector3d& gravity_B,
                   const JointVector& q_start, double step_s, ServoParameters servo)
    : model_(std::move(model)),
      gravity_B_(gravity_B),
      step_s_(step_s),
      servo_(servo),
      max_torque_(model_.dof()),
      max_speed_(model_.dof()) {
  const int n = model_.dof();
  assert(q_start.size() == n && step_s > 0);
  for (int i = 0; i < n; ++i) {
    max_torque_(i) = model_.joints[static_cast<std::size_t>(i)].max_torque_nm;
    max_speed_(i) = model_.joints[static_cast<std::size_t>(i)].max_speed_rad_s;
  }
  s_.payload = std::move(payload);
  s_.limit = max_torque_;
  s_.q_ref = s_.q = q_start;
  s_.applied = JointVector::Zero(n);
  s_.qd_ref = s_.e = s_.ed = s_.integral = s_.qd = JointVector::Zero(n);
  s_.torque = inverse_dynamics(model_, s_.payload, gravity_B_, s_.q, s_.qd, s_.qd);
  s_.trip_reason.reserve(kReasonCapacity);
}

void ServoArm::step(const JointVector& q_ref_next, const JointVector& tau_ext,
                    const JointVector& tau_load) {
  assert(q_ref_next.size() == model_.dof() && tau_ext.size() == model_.dof());
  if (s_.braked) return step_braked(q_ref_next);
  // Computed-torque feedforward with a decentralised servo (Siciliano et al. 2009, sec. 8.4).
  // Velocity and acceleration as this step realises them: a feedforward from them leaves no
  // tracking error.
  const JointVector qd_ref_next = (q_ref_next - s_.q_ref) / step_s_;
  const JointVector qdd_ref = (qd_ref_next - s_.qd_ref) / step_s_;
  const JointVector feedforward =
      inverse_dynamics(model_, s_.payload, gravity_B_, s_.q_ref, qd_ref_next, qdd_ref);
  const JointVector disturbance = beyond_friction(tau_ext);
  // In free motion the deviation is exactly zero and its dynamics is skipped: results do not depend
  // on rounding of a servo that has nothing to do.
  const bool overloaded = (feedforward.array().abs() > s_.limit.array()).any();
  const bool disturbed = (disturbance.array() != 0).any();

  if (s_.deviating || overloaded || disturbed) {
    deviate(feedforward, disturbance);
    check_trip(feedforward);
    const bool settled = !overloaded && !disturbed && (s_.e.array().abs() < kSettledAngle).all() &&
                         (s_.ed.array().abs() < kSettledSpeed).all();
    s_.deviating = !settled;
    if (settled) s_.e = s_.ed = s_.integral = JointVector::Zero(model_.dof());
  } else {
    s_.torque = feedforward;
  }
  s_.q_ref = q_ref_next;
  s_.qd_ref = qd_ref_next;
  if (s_.deviating) {
    s_.q = s_.q_ref + s_.e;
    s_.qd = s_.qd_ref + s_.ed;
  } else {
    s_.q = s_.q_ref;
    s_.qd = s_.qd_ref;
    s_.disturbed_steps = 0;
  }
  add_held_load(tau_load);
}

/// Adds the part of a load within friction, which the servo does not answer.
void ServoArm::add_held_load(const JointVector& tau_load) {
  if (tau_load.size() == 0 || (tau_load.array() == 0).all()) return;
  const JointVector within = tau_load - beyond_friction(tau_load);
  // Reported torque only: the arm does not move for it.
  s_.torque = (s_.torque - within).cwiseMax(-s_.limit).cwiseMin(s_.limit);
}

/// One step with the brakes on: nothing moves, and a deviation stays.
void ServoArm::step_braked(const JointVector& q_ref_next) {
  s_.q_ref = q_ref_next;
  s_.e = s_.q - s_.q_ref;
  s_.deviating = (s_.e.array() != 0).any();
  s_.disturbed_steps = 0;
  for (JointVector* rate : {&s_.qd_ref, &s_.qd, &s_.ed, &s_.integral, &s_.torque}) rate->setZero();
}

/// External torque beyond the joints' static friction.
JointVector ServoArm::beyond_friction(const JointVector& tau_ext) const {
  JointVector out(model_.dof());
  for (int i = 0; i < model_.dof(); ++i) {
    // Static friction of the gears as a dead band: a light touch does not move a strongly geared
    // joint.
    const double friction = servo_.friction_fraction * max_torque_(i);
    const double excess = std::abs(tau_ext(i)) - friction;
    out(i) = excess > 0 ? std::copysign(excess, tau_ext(i)) : 0.0;
  }
  return out;
}

/// Return speed of each joint to its reference: proportional close to it, a braking parabola with a
/// share of the torque from farther away, so that a saturated joint does not limit-cycle.
JointVector ServoArm::return_speed(const JointMatrix& H) const {
  JointVector out(model_.dof());
  for (int i = 0; i < model_.dof(); ++i) {
    const double distance = std::abs(s_.e(i));
    const double braking = kReturnTorque * s_.limit(i) / H(i, i);
    // The parabola v^2 = knee^2 + 2 a s and the line v = k s meet where both have about the same
    // slope.
    const double knee = braking / servo_.position_gain_1_s;
    const double speed =
        std::min({servo_.position_gain_1_s * distance, kReturnSpeed * max_speed_(i),
                  std::sqrt(knee * knee + 2 * braking * distance)});
    out(i) = -std::copysign(speed, s_.e(i));
  }
  return out;
}

/// One semi-implicit Euler step of the deviation: H edd = torque - feedforward + disturbance.
void ServoArm::deviate(const JointVector& feedforward, const JointVector& disturbance) {
  const JointMatrix H = robot::mass_matrix(model_, s_.payload, s_.q_ref + s_.e);
  const JointVector wanted = return_speed(H);
  // Velocity loop inside a position loop, with integral action; torques saturate.
  // Cascade control: the position loop sets a speed, the velocity loop with integral action an
  // acceleration, and H turns it into torques (inverse dynamics of the deviation).
  const JointVector u =
      servo_.velocity_gain_1_s * (wanted - s_.ed - servo_.integral_gain_1_s * s_.integral);
  const JointVector demanded = feedforward + H * u;
  s_.torque = demanded.cwiseMax(-s_.limit).cwiseMin(s_.limit);
  const JointVector net = s_.torque - feedforward + disturbance;
  // H is positive definite, so that Cholesky applies. Velocity first, then position.
  s_.ed += step_s_ * H.llt().solve(net);
  s_.e += step_s_ * s_.ed;
  // Anti-windup: a saturated joint's integral decays.
  for (int i = 0; i < model_.dof(); ++i) {
    if (demanded(i) == s_.torque(i)) {
      s_.integral(i) += step_s_ * (s_.ed(i) - wanted(i));
    } else {
      s_.integral(i) *= kIntegralDecay;
    }
  }
}

/// Trip conditions: disturbance torque of a drive, or deviation from the reference.
void ServoArm::check_trip(const JointVector& feedforward) {
  // A feedforward beyond the limit is the plan's fault and shows as deviation, not as disturbance.
  const JointVector planned = feedforward.cwiseMax(-s_.limit).cwiseMin(s_.limit);
  // Sensorless collision detection: the drive's torque beyond the model's (De Luca et al. 2006, in
  // its simplest form).
  const JointVector against = ((s_.torque - planned).cwiseAbs() - s_.applied).cwiseMax(0);
  // The joint with the largest share of its trip torque.
  int worst = 0;
  double worst_share = 0, limit = 0;
  for (int i = 0; i < model_.dof(); ++i) {
    const double bearable = trip_torque(model_, s_.payload, i, servo_.trip_fraction);
    if (against(i) / bearable <= worst_share) continue;
    worst = i;
    worst_share = against(i) / bearable;
    limit = bearable;
  }
  s_.disturbed_steps = worst_share > 1 ? s_.disturbed_steps + 1 : 0;
  if (!s_.trip_reason.empty()) return;
  if (s_.disturbed_steps >= kTripSteps) {
    trip(worst, "disturbance torque", against(worst), limit, "Nm");
    return;
  }
  Eigen::Index farthest = 0;
  const double deviation = s_.e.cwiseAbs().maxCoeff(&farthest);
  if (deviation > servo_.trip_deviation_rad) {
    trip(static_cast<int>(farthest), "deviation from the reference", deviation,
         servo_.trip_deviation_rad, "rad");
  }
}

void ServoArm::trip(int joint, const char* what, double value, double limit, const char* unit) {
  char text[kReasonCapacity];
  std::snprintf(text, sizeof text, "%s: %s %.3g %s, limit %.3g %s",
                model_.joints[static_cast<std::size_t>(joint)].name.c_str(), what, value, unit,
                limit, unit);
  s_.trip_reason.assign(text);  // within the capacity reserved at construction
}

void ServoArm::relax() {
  s_.q_ref = s_.q;
  s_.qd_ref = s_.qd;
  s_.e = s_.ed = s_.integral = JointVector::Zero(model_.dof());
  s_.deviating = false;
  clear_trip();
}

void ServoArm::clear_trip() {
  s_.disturbed_steps = 0;
  s_.trip_reason.clear();
}

void ServoArm::restore(const State& state) { s_ = state; }

void ServoArm::set_torque_share(std::span<const double> share) {
  for (int i = 0; i < model_.dof(); ++i) {
    s_.limit(i) = share[static_cast<std::size_t>(i)] * max_torque_(i);
  }
}

void ServoArm::set_payload(const Payload& payload) { s_.payload = payload; }

}  // namespace aprsim::robot
