#pragma once

namespace aprsim::physics {

/// Warm start of a force or a torque: `last`, or extrapolated linearly to `last` + `change`.
/// `Value`: a number or a vector.
template <typename Value>
struct ForceGuess {
  Value last, change;
  int fitting_steps = 0;  ///< number of steps in a row whose warm start was the solution
  bool known = false;

  explicit ForceGuess(const Value& begin) : last(begin), change(0 * begin) {}

  /// Records the solution of a step. `warm_start_fits`: it is the warm start. A warm start within
  /// the tolerance still lets bodies drift, until a step corrects the drift with a different force.
  /// The holding force is the mean over all these steps, since their sum was needed.
  void record(const Value& found, bool warm_start_fits) {
    const bool corrects = known && !warm_start_fits && fitting_steps > 0;
    const Value off = found - last;
    if (corrects) {
      last += off / (fitting_steps + 1);
    } else {
      last = found;
    }
    change = known && !corrects ? off : Value(0 * off);
    fitting_steps = warm_start_fits ? fitting_steps + 1 : 0;
    known = true;
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [last, change, fitting_steps, known] = self;
    io(last, change, fitting_steps, known);
  }
};

}  // namespace aprsim::physics
