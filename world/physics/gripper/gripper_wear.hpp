#pragma once

#include <array>

namespace aprsim::physics {

/// Wear of a gripper, as shares of the values when new.
struct GripperWear {
  double pad_friction = 1;
  std::array<double, 2> finger_speed{1, 1};

  bool operator==(const GripperWear&) const = default;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [pad_friction, finger_speed] = self;
    io(pad_friction, finger_speed);
  }
};

}  // namespace aprsim::physics
