#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "world/scene/model/scene.hpp"

/// Force laws of a parallel gripper: pure functions of the fingers' closing travels.
namespace aprsim::physics {

/// Drive of one finger in one step: a piston with a speed limit (signed, closing positive) and a
/// force limit, and an additional force along the closing direction.
struct FingerDrive {
  double speed_m_s = 0;
  double piston_n = 0;
  double extra_n = 0;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [speed_m_s, piston_n, extra_n] = self;
    io(speed_m_s, piston_n, extra_n);
  }
};

struct FingerMotion {
  double travel_m = 0;  ///< closing travel, 0 = open
  double rate_m_s = 0;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [travel_m, rate_m_s] = self;
    io(travel_m, rate_m_s);
  }
};

/// Eq. 3 of the paper, for any set of mimic joints: `on[i]` = single(joint i) + sum over n != i of
/// pair(joint n, joint i), where `pair` is the force on the second from its error to the first.
/// `on` has as many elements as `joints`. No call allocates.
template <class Single, class Pair>
void mimic_joint_forces(std::span<const FingerMotion> joints, const Single& single,
                        const Pair& pair, std::span<double> on) {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    on[i] = single(joints[i]);
    for (std::size_t n = 0; n < joints.size(); ++n) {
      if (n != i) on[i] += pair(joints[n], joints[i]);
    }
  }
}

/// The coupling part of eq. 3 with a linear relative-error law: stiffness (p_n - p_i) + damping
/// (p'_n - p'_i). With two fingers this is that of eq. 1-2.
void coupling_forces(std::span<const FingerMotion> fingers, double stiffness_n_m,
                     double damping_ns_m, std::span<double> on);

/// State of the mimic-joint controller.
struct MimicState {
  double integral_n = 0;  ///< its integral share [N]

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [integral_n] = self;
    io(integral_n);
  }
};

/// PID force on a joint that is to follow another, from the difference of travels and of rates.
/// Anti-windup: the integral share is bounded by `max_n`, and constant while the whole force is at
/// that limit and the error would increase it.
[[nodiscard]] double mimic_pid_force(const scene::MimicPid& gains, double max_n, double error_m,
                                     double error_rate_m_s, double step_s, MimicState& state);

/// Pressures of the two chambers that drive the fingers, as shares of the supply's.
struct Chambers {
  double closing = 0, opening = 1;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [closing, opening] = self;
    io(closing, opening);
  }
};

/// Share of the supply pressure that a chamber with this leak reaches.
[[nodiscard]] double full_pressure(const scene::Gripper& gripper);
/// The valve feeds one chamber and vents the other; both follow with the fill time, exactly.
void advance_air(const scene::Gripper& gripper, bool closing, double step_s, Chambers& air);
/// Whether the force is within 1 % of its final value.
[[nodiscard]] bool air_is_steady(const scene::Gripper& gripper, bool closing, const Chambers& air);

/// State of the force laws.
struct LawState {
  Chambers air;
  MimicState mimic;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [air, mimic] = self;
    io(air, mimic);
  }
};

/// Drives of both fingers for a command (`closing`), with `end_m` the travel of the closed stop.
/// The air is throttled near either end, as in cushioned cylinders. Friction reduces the push of
/// the piston and increases the force that pushes it back. kConstant: each piston for itself.
/// kMimicPid: the first by its piston, the second by a PID on the difference of travels, as the
/// mimic-joint plugin does. kCoupled: both pistons plus eq. 1-2. kLinkage: both pistons; the
/// linkage itself is a constraint, not a force.
[[nodiscard]] std::array<FingerDrive, 2> finger_drives(const scene::Gripper& gripper, bool closing,
                                                       const std::array<FingerMotion, 2>& fingers,
                                                       double end_m, double step_s,
                                                       LawState& state);

/// Drives of both fingers of a servo gripper on their way to the closing travel `target_m`: at
/// finger speed, slower over the last millimetres, with at most the gripper's force.
[[nodiscard]] std::array<FingerDrive, 2> servo_drives(const scene::Gripper& gripper,
                                                      double target_m,
                                                      const std::array<FingerMotion, 2>& fingers);

}  // namespace aprsim::physics
