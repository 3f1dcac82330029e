#pragma once

#include <array>

#include "world/physics/gripper/finger_drive.hpp"
#include "world/physics/gripper/gripper_state.hpp"

namespace aprsim::physics {

/// Contact forces on the pads in one step.
struct PadForces {
  /// Reaction of bodies on each pad along its closing direction.
  std::array<double, 2> closing_n{};
  std::array<int, 2> body{-1, -1};  ///< that each pad presses hardest, by body index
  std::array<double, 2> body_n{};   ///< force on it
  bool joined = false;              ///< the two bodies are one, or touch through other free bodies

  /// The body that is pressed harder.
  [[nodiscard]] int hardest() const { return body_n[0] < body_n[1] ? body[1] : body[0]; }
};

/// Detects from measurable quantities whether a gripper is settled, holds a gear or a tray, or may
/// become idle. Each needs some steps in a row. A value: copied with the gripper's state.
class GraspMonitor {
 public:
  struct Observation {
    const PadForces& pads;
    const std::array<FingerMotion, 2>& motion;
    double stop_travel_m = 0;    ///< where the fingers stop with nothing between them
    double closed_travel_m = 0;  ///< of the closed end stop
    double force_n = 0;          ///< of each finger
    bool at_full_force = false;  ///< the drive has built up its force
    bool touched = false;        ///< by anything
  };

  /// A new command: not settled until the fingers are at rest again.
  void restart(GripperState& state);
  /// A body is near: not idle for some steps.
  void stay_awake() { idle_steps_ = 0; }
  /// Updates settled, holding and held_body. True if the gripper may become idle.
  bool observe(const Observation& now, GripperState& state);

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [still_steps, hold_steps, lost_steps, idle_steps] = self;
    io(still_steps, hold_steps, lost_steps, idle_steps);
  }

 private:
  void update_hold(const Observation& now, bool still, GripperState& state);

  int still_steps_ = 0, hold_steps_ = 0, lost_steps_ = 0, idle_steps_ = 0;
};

}  // namespace aprsim::physics
