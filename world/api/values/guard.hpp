#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "world/api/values/pose.hpp"
#include "world/api/values/ticket.hpp"
#include "world/base/time.hpp"

/// Conditions on a robot's own sensors that end one of its commands.
namespace aprsim::api {

/// A measurement of a robot; each names its `index`.
enum class SignalKind {
  kForceR,        ///< contact force on the tool and what it holds, axis 0..2 of R [N]
  kTorqueR,       ///< of these forces about the tool point, axis 0..2 of R [Nm]
  kForceT,        ///< the same along the axes of the tool [N]
  kTorqueT,       ///< [Nm]
  kJointTorque,   ///< of the drive of joint 0.. [Nm]
  kGripForce,     ///< normal force of finger 0 or 1 on what it holds [N]
  kSeparation,    ///< pad to pad [m]
  kPartPresent,   ///< 1 while the gripper holds something, else 0
  kLightCurtain,  ///< 1 while the cell's light curtain is broken, else 0
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr SignalKind last_of(SignalKind) { return SignalKind::kLightCurtain; }
struct Signal {
  SignalKind kind = SignalKind::kForceR;
  int index = 0;
  bool reversed = false;  ///< reads with the opposite sign
};

enum class GuardLimit {
  kOverMax,    ///< the value is above the limit
  kUnderMin,   ///< the value is below the limit
  kIncreased,  ///< the value is above that at the command's start by more than the limit
  kDecreased,  ///< the value is below that at the command's start by more than the limit
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr GuardLimit last_of(GuardLimit) { return GuardLimit::kDecreased; }

inline constexpr std::size_t kMaxGuards = 8;
inline constexpr SimTime kGuardRecheck = std::chrono::milliseconds(10);

/// Ends its command when the condition holds: the motion stops on its path as fast as it can and
/// the command is done, or in error.
struct Guard {
  Signal signal;
  GuardLimit limit = GuardLimit::kOverMax;
  double value = 0;                 ///< SI
  SimTime recheck = kGuardRecheck;  ///< simulated; at least one step
  bool require_trigger = false;     ///< the command is in error if it ends without a trigger
  bool error_on_trigger = false;    ///< the command is in error if the guard triggers
  std::string label;                ///< for messages
};

struct GuardSnapshot {
  std::uint64_t checks = 0;
  SimTime last_check{};
  double last_value = 0;
};

/// The guards of the latest command that had any, and the latest trigger.
struct GuardsSnapshot {
  Ticket ticket = 0;  ///< of that command; 0 = none so far
  std::size_t count = 0;
  std::array<GuardSnapshot, kMaxGuards> guards;
  std::uint32_t triggers = 0;     ///< since reset
  SimTime stop_time{};            ///< from the trigger to rest
  std::size_t trigger_guard = 0;  ///< which of them
  double trigger_value = 0;
  Pose trigger_X_RT;  ///< tool in the robot's reference frame at the trigger
};

}  // namespace aprsim::api
