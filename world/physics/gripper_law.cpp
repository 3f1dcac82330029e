#include "world/physics/gripper_law.hpp"

#include <algorithm>
#include <cstddef>

namespace aprsim::physics {
namespace {

constexpr double kCouplingDamping = 20;  // [N s/m], of the linkage that the coupling stands for
constexpr double kMimicIntegral = 10;    // [1/s], integral gain relative to the proportional one
constexpr double kCushionRate = 60;      // [1/s], speed left per distance to the end stop
constexpr double kCreep = 0.01;          // [m/s], speed into the stop

double throttled(double speed, double distance) {
  return std::min(speed, kCreep + kCushionRate * std::max(0.0, distance));
}

FingerDrive piston(const scene::Gripper& gripper, bool closing, double travel, double end) {
  FingerDrive drive;
  drive.piston_n = gripper.force_n;
  drive.speed_m_s = closing ? throttled(gripper.finger_speed_m_s, end - travel)
                            : -throttled(gripper.finger_speed_m_s, travel);
  return drive;
}

double mimic_force(const scene::Gripper& gripper, const std::array<FingerMotion, 2>& fingers,
                   double step_s, MimicState& mimic) {
  const double error = fingers[0].travel_m - fingers[1].travel_m;
  const double rate = fingers[0].rate_m_s - fingers[1].rate_m_s;
  const double bound = gripper.force_n / (gripper.coupling_n_m * kMimicIntegral);
  mimic.integral_ms = std::clamp(mimic.integral_ms + error * step_s, -bound, bound);
  return gripper.coupling_n_m * (error + kMimicIntegral * mimic.integral_ms) +
         kCouplingDamping * rate;
}

}  // namespace

void coupling_forces(std::span<const FingerMotion> fingers, double stiffness_n_m,
                     double damping_ns_m, std::span<double> on) {
  for (std::size_t i = 0; i < fingers.size(); ++i) {
    on[i] = 0;
    for (std::size_t n = 0; n < fingers.size(); ++n) {
      if (n == i) continue;
      on[i] += stiffness_n_m * (fingers[n].travel_m - fingers[i].travel_m) +
               damping_ns_m * (fingers[n].rate_m_s - fingers[i].rate_m_s);
    }
  }
}

std::array<FingerDrive, 2> finger_drives(const scene::Gripper& gripper, bool closing,
                                         const std::array<FingerMotion, 2>& fingers, double end_m,
                                         double step_s, MimicState& mimic) {
  std::array<FingerDrive, 2> drives;
  for (std::size_t i = 0; i < 2; ++i) {
    drives[i] = piston(gripper, closing, fingers[i].travel_m, end_m);
  }
  if (gripper.law == scene::GripperLaw::kMimicPid) {
    drives[1] = {};
    drives[1].extra_n = mimic_force(gripper, fingers, step_s, mimic);
  } else if (gripper.law == scene::GripperLaw::kCoupled) {
    std::array<double, 2> coupling{};
    coupling_forces(fingers, gripper.coupling_n_m, kCouplingDamping, coupling);
    for (std::size_t i = 0; i < 2; ++i) drives[i].extra_n = coupling[i];
  }
  return drives;
}

}  // namespace aprsim::physics
