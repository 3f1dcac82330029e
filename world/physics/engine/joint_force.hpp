#pragma once

#include "world/physics/bodies/force_guess.hpp"

namespace aprsim::physics {

/// A scalar force or torque of a joint. It is read after a step, and an engine may start the next
/// step from it. Joints never use a mean force.
struct JointForce {
  ForceGuess<double> guess_n{0};
  /// In the last step.
  [[nodiscard]] double last_n() const { return guess_n.last; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [guess_n] = self;
    io(guess_n);
  }
};

}  // namespace aprsim::physics
