#pragma once

#include <array>

#include "world/faults/robot_faults.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::world {

/// Differences between the joints' encoders and the links: play of the joints, and errors of the
/// encoders, which come and go at a moderate speed. A copyable value. Thread: sim.
class JointErrors {
 public:
  /// Faults have changed: from now on step() makes their errors.
  void begin(const RobotFaults& faults);
  /// One step, with what the encoders read at its end. A link follows its encoder at the ends of
  /// the joint's play only.
  void step(const robot::JointVector& q, const RobotFaults& faults, double step_s);

  /// False: every link is where its encoder says.
  [[nodiscard]] bool any() const { return any_; }
  /// Joint positions of the links, for what the encoders read.
  [[nodiscard]] robot::JointVector links_at(const robot::JointVector& q) const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [play_rad, half_width_rad, bias_rad, q_before, any] = self;
    io(play_rad, half_width_rad, bias_rad, q_before, any);
  }

 private:
  std::array<double, api::kMaxJoints> play_rad_{}, half_width_rad_{}, bias_rad_{};
  robot::JointVector q_before_;  ///< of the last step; empty = no errors
  bool any_ = false;             ///< some of these are not zero
};

}  // namespace aprsim::world
