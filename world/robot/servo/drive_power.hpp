#pragma once

namespace aprsim::robot {

/// Whether an arm's drives hold it, or its brakes with the drives off: after an immediate stop, and
/// some time after a fast one (CRCL's StopConditionEnumType). A copyable value. Thread: sim.
class DrivePower {
 public:
  /// Off after so many steps, or at rest if that is later.
  void switch_off_after(int steps) { off_in_ = steps; }
  void cancel_switch_off() { off_in_ = kNever; }
  /// On; brakes that were engaged need so many steps to release.
  void switch_on(int release_steps) {
    cancel_switch_off();
    if (!on_) release_in_ = release_steps;
    on_ = true;
  }
  /// One step. `at_rest`: no motion is under way.
  void step(bool at_rest) {
    if (release_in_ > 0) --release_in_;
    if (off_in_ > 0) --off_in_;
    if (off_in_ != 0 || !at_rest) return;
    on_ = false;
    cancel_switch_off();
  }

  [[nodiscard]] bool on() const { return on_; }
  /// On, but the arm cannot be moved yet.
  [[nodiscard]] bool releasing() const { return release_in_ > 0; }
  /// The brakes hold the arm.
  [[nodiscard]] bool braked() const { return !on_ || releasing(); }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [on, off_in, release_in] = self;
    io(on, off_in, release_in);
  }

 private:
  static constexpr int kNever = -1;

  bool on_ = true;
  int off_in_ = kNever, release_in_ = 0;
};

}  // namespace aprsim::robot
