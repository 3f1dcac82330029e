#pragma once

#include <array>

#include "world/api/values/pose.hpp"

namespace aprsim::physics {

/// Readings of a gripper after a step.
struct GripperState {
  double separation_m = 0;
  std::array<double, 2> travel_m{};
  std::array<double, 2> force_n{};  ///< pad normal force on gears and trays
  bool holding = false;
  int held_body = -1;   ///< index of the gear or tray between the pads or at the cup, -1 = none
  bool settled = true;  ///< the command is complete: open, closed, or stalled on a part
  double palm_deflection_m = 0;
  double vacuum_pa = 0;  ///< of a cup
  Pose X_WT;             ///< real pose of the tool frame, with the mount's deflection

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [separation_m, travel_m, force_n, holding, held_body, settled, palm_deflection_m,
           vacuum_pa, X_WT] = self;
    io(separation_m, travel_m, force_n, holding, held_body, settled, palm_deflection_m, vacuum_pa,
       X_WT);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.index_or_none(In::kPart, held_body);
  }
};

}  // namespace aprsim::physics
