#pragma once

namespace aprsim::world {

/// Effects of injected faults on the belt; the defaults are those of a sound belt.
struct BeltFaults {
  bool jammed = false;
  bool reversed = false;     ///< runs against the direction set
  double speed_factor = 1;   ///< on the speed set
  double surface_share = 1;  ///< of the drive's speed that the belt's surface has
  bool encoder_frozen = false;
  bool emergency_stop = false;  ///< the cell's, engaged as if by the drive's input

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [jammed, reversed, speed_factor, surface_share, encoder_frozen, emergency_stop] = self;
    io(jammed, reversed, speed_factor, surface_share, encoder_frozen, emergency_stop);
  }
};

}  // namespace aprsim::world
