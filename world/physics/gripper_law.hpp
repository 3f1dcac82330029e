#pragma once

#include <array>
#include <span>

#include "world/scene/scene.hpp"

/// Force laws of a pneumatic parallel gripper: pure functions of the fingers' closing travels.
namespace aprsim::physics {

/// What drives one finger in one step: a piston that moves at most at `speed` (signed, closing
/// positive) and pushes with at most `force`, and a further force along the closing direction.
struct FingerDrive {
  double speed_m_s = 0;
  double piston_n = 0;
  double extra_n = 0;
};

struct FingerMotion {
  double travel_m = 0;  ///< closing travel, 0 = open
  double rate_m_s = 0;
};

/// The coupling part of eq. 3: `on[i]` = sum over n != i of stiffness (p_n - p_i) + damping
/// (p'_n - p'_i). With two fingers this is eq. 1-2. No call allocates.
void coupling_forces(std::span<const FingerMotion> fingers, double stiffness_n_m,
                     double damping_ns_m, std::span<double> on);

/// Keeps what the mimic controller integrates.
struct MimicState {
  double integral_ms = 0;  ///< of the travel difference [m s]
};

/// Drives of both fingers for a command (`closing`), with `end_m` the travel of the closed stop.
/// The air is throttled near either end, as cushioned cylinders do.
/// kConstant: each piston for itself. kMimicPid: the first by its piston, the second by a PID on
/// the difference of travels, as the mimic-joint plugin does. kCoupled: both pistons plus eq. 1-2.
/// kLinkage: both pistons; the linkage itself is a constraint, not a force.
[[nodiscard]] std::array<FingerDrive, 2> finger_drives(const scene::Gripper& gripper, bool closing,
                                                       const std::array<FingerMotion, 2>& fingers,
                                                       double end_m, double step_s,
                                                       MimicState& mimic);

}  // namespace aprsim::physics
