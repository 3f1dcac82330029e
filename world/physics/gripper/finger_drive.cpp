#include "world/physics/gripper/finger_drive.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics {
namespace {

constexpr double kCouplingDamping = 20;  // [N s/m], of the linkage that the coupling stands for
constexpr double kCushionRate = 60;      // [1/s], speed left per distance to the end stop
constexpr double kCreep = 0.01;          // [m/s], speed into the stop
constexpr double kPushedBack = 1e-3;     // [m/s]
constexpr double kSteady = 0.01;         // share of the full pressure
constexpr double kServoRate = 80;        // [1/s], speed of a servo per distance left

double throttled(double speed, double distance) {
  return std::min(speed, kCreep + kCushionRate * std::max(0.0, distance));
}

/// A pneumatic piston: net pressure less Coulomb friction, speed throttled near the end
/// (cushioning).
FingerDrive piston(const scene::Gripper& gripper, const Chambers& air, const FingerMotion& finger,
                   double end) {
  // Force of both chambers. The nominal force is what remains after seal friction, so that friction
  // is added first.
  const double gross = (gripper.force_n + gripper.friction_n) * (air.closing - air.opening);
  const double push = std::abs(gross) - gripper.friction_n;
  FingerDrive drive;
  if (push <= 0) {  // friction holds the finger
    drive.piston_n = gripper.friction_n;
    return drive;
  }
  const bool closing = gross > 0;
  const bool pushed_back = (closing ? finger.rate_m_s : -finger.rate_m_s) < -kPushedBack;
  // Coulomb friction of the seals acts against the motion: it lowers the push and raises the force
  // needed to push back, a hysteresis of 2 F.
  drive.piston_n = pushed_back ? push + 2 * gripper.friction_n : push;
  drive.speed_m_s = closing ? throttled(gripper.finger_speed_m_s, end - finger.travel_m)
                            : -throttled(gripper.finger_speed_m_s, finger.travel_m);
  return drive;
}

}  // namespace

/// Eq. 3 of IMECE2019-11345 without a single-joint law; for two fingers the terms kp (p2 - p1) and
/// kp (p1 - p2) of eq. 1-2.
void coupling_forces(std::span<const FingerMotion> fingers, double stiffness_n_m,
                     double damping_ns_m, std::span<double> on) {
  mimic_joint_forces(
      fingers, [](const FingerMotion&) { return 0.0; },
      [&](const FingerMotion& other, const FingerMotion& own) {
        return stiffness_n_m * (other.travel_m - own.travel_m) +
               damping_ns_m * (other.rate_m_s - own.rate_m_s);
      },
      on);
}

double mimic_pid_force(const scene::MimicPid& gains, double max_n, double error_m,
                       double error_rate_m_s, double step_s, MimicState& state) {
  const double direct = gains.p_n_m * error_m + gains.d_ns_m * error_rate_m_s;
  const double grown =
      std::clamp(state.integral_n + gains.i_n_ms * error_m * step_s, -max_n, max_n);
  const double wanted = direct + grown;
  // Conditional integration: not while it would drive the force further into its limit.
  const bool winding_up = std::abs(wanted) > max_n && wanted * error_m > 0;
  if (!winding_up) state.integral_n = grown;
  return std::clamp(direct + state.integral_n, -max_n, max_n);
}

double full_pressure(const scene::Gripper& gripper) {
  return 1 / (1 + gripper.leak_per_s * gripper.fill_time_s);
}

void advance_air(const scene::Gripper& gripper, bool closing, double step_s, Chambers& air) {
  const double full = full_pressure(gripper);
  // First-order filling and venting, exact over the step.
  // dp/dt = (p_end - p) / T has the solution p_end + (p - p_end) exp(-h / T).
  const double kept =
      gripper.fill_time_s > 0 ? std::exp(-step_s / (gripper.fill_time_s * full)) : 0;
  const double closing_end = closing ? full : 0, opening_end = closing ? 0 : full;
  air.closing = closing_end + kept * (air.closing - closing_end);
  air.opening = opening_end + kept * (air.opening - opening_end);
}

bool air_is_steady(const scene::Gripper& gripper, bool closing, const Chambers& air) {
  const double full = full_pressure(gripper);
  const double now = closing ? air.closing - air.opening : air.opening - air.closing;
  return now >= (1 - kSteady) * full;
}

std::array<FingerDrive, 2> finger_drives(const scene::Gripper& gripper, bool closing,
                                         const std::array<FingerMotion, 2>& fingers, double end_m,
                                         double step_s, LawState& state) {
  advance_air(gripper, closing, step_s, state.air);
  std::array<FingerDrive, 2> drives;
  for (std::size_t i = 0; i < 2; ++i) drives[i] = piston(gripper, state.air, fingers[i], end_m);
  if (gripper.law == scene::GripperLaw::kMimicPid) {
    // The baseline of the paper: the first finger by constant force, the second by a PID on the
    // difference of travels.
    const double max_n = gripper.mimic.max_n > 0 ? gripper.mimic.max_n : gripper.force_n;
    drives[1] = {};
    drives[1].extra_n =
        mimic_pid_force(gripper.mimic, max_n, fingers[0].travel_m - fingers[1].travel_m,
                        fingers[0].rate_m_s - fingers[1].rate_m_s, step_s, state.mimic);
  } else if (gripper.law == scene::GripperLaw::kCoupled) {
    std::array<double, 2> coupling{};
    coupling_forces(fingers, gripper.coupling_n_m, kCouplingDamping, coupling);
    for (std::size_t i = 0; i < 2; ++i) drives[i].extra_n = coupling[i];
  }
  return drives;
}

std::array<FingerDrive, 2> servo_drives(const scene::Gripper& gripper, double target_m,
                                        const std::array<FingerMotion, 2>& fingers) {
  std::array<FingerDrive, 2> drives;
  for (std::size_t i = 0; i < 2; ++i) {
    const double wanted = kServoRate * (target_m - fingers[i].travel_m);
    drives[i].speed_m_s = std::clamp(wanted, -gripper.finger_speed_m_s, gripper.finger_speed_m_s);
    drives[i].piston_n = gripper.force_n;
  }
  return drives;
}

}  // namespace aprsim::physics
