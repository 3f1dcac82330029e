#pragma once

namespace aprsim::physics {

/// Where the search for a force or a torque begins: at `last`, or by `change` farther. `Value`: a
/// number or a vector.
template <typename Value>
struct ForceGuess {
  Value last, change;
  int held = 0;  ///< for how many steps the force has been as it was guessed
  bool known = false;

  explicit ForceGuess(const Value& begin) : last(begin), change(0 * begin) {}

  /// What was found in a step, and whether it is what had been guessed. Guesses that fit within the
  /// tolerance still let bodies drift, until a step puts right what has come together. What holds
  /// the bodies is neither, but the mean of all these steps: their sum is what was needed, as far
  /// as nothing else has changed.
  void note(const Value& found, bool as_guessed) {
    const bool corrects = known && !as_guessed && held > 0;
    const Value off = found - last;
    if (corrects) {
      last += off / (held + 1);
    } else {
      last = found;
    }
    change = known && !corrects ? off : Value(0 * off);
    held = as_guessed ? held + 1 : 0;
    known = true;
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [last, change, held, known] = self;
    io(last, change, held, known);
  }
};

}  // namespace aprsim::physics
