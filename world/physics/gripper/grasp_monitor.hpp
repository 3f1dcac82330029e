#pragma once

#include <array>

#include "world/physics/gripper/finger_drive.hpp"
#include "world/physics/gripper/gripper_state.hpp"

namespace aprsim::physics {

/// What the pads met in one step.
struct PadForces {
  std::array<double, 2>
      closing_n{};                  ///< reaction of bodies on each pad along its closing direction
  std::array<int, 2> body{-1, -1};  ///< that each pad presses hardest, by body index
};

/// Decides from what can be measured of a gripper whether it is settled, holds a gear or a tray, or
/// may be left alone (idle). Each needs some steps in a row. A value: copied with the gripper's
/// state.
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

  /// A new command: not settled until the fingers have come to rest anew.
  void restart(GripperState& state);
  /// Something is near: not to be left alone for a while.
  void stay_awake() { idle_steps_ = 0; }
  /// Updates settled, holding and held_body. True when the gripper may be left alone.
  bool observe(const Observation& now, GripperState& state);

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [still_steps, hold_steps, lost_steps, idle_steps] = self;
    io(still_steps, hold_steps, lost_steps, idle_steps);
  }

 private:
  void watch_hold(const Observation& now, bool still, GripperState& state);

  int still_steps_ = 0, hold_steps_ = 0, lost_steps_ = 0, idle_steps_ = 0;
};

}  // namespace aprsim::physics
