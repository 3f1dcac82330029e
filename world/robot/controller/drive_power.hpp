#pragma once

namespace aprsim::robot {

/// Whether an arm's drives hold it, or with the drives off its brakes; after an immediate stop, and
/// some time after a fast one (CRCL's StopConditionEnumType). A copyable value. Thread: sim.
class DrivePower {
 public:
  /// Off at rest, as soon as so many steps have passed.
  void switch_off_after(int steps) { off_in_ = steps; }
  /// As they are: nothing that was to switch them off still does.
  void keep() { off_in_ = kNever; }
  /// On; where they were off the brakes take so many steps to release.
  void switch_on(int release_steps) {
    keep();
    if (!on_) release_in_ = release_steps;
    on_ = true;
  }
  /// One step. `at_rest`: no motion is under way.
  void step(bool at_rest) {
    if (release_in_ > 0) --release_in_;
    if (off_in_ > 0) --off_in_;
    if (off_in_ != 0 || !at_rest) return;
    on_ = false;
    keep();
  }

  [[nodiscard]] bool on() const { return on_; }
  /// On, but the arm cannot be moved yet.
  [[nodiscard]] bool releasing() const { return release_in_ > 0; }
  /// The brakes hold the arm.
  [[nodiscard]] bool braked() const { return !on_ || releasing(); }

 private:
  static constexpr int kNever = -1;

  bool on_ = true;
  int off_in_ = kNever, release_in_ = 0;
};

}  // namespace aprsim::robot
