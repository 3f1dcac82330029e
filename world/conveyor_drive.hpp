#pragma once

#include <optional>

#include "world/api/command.hpp"
#include "world/api/snapshot.hpp"

namespace aprsim::world {

/// The belt's drive: three inputs (run, direction, speed), one signed speed that follows them with
/// the drive's acceleration limit, so a change of direction goes through zero. Thread: sim.
class ConveyorDrive {
 public:
  ConveyorDrive(double max_speed_m_s, double max_accel_m_s2);

  void take(const api::ConveyorCommand& command);
  /// Advances by `step_s` and returns the belt's speed at its end [m/s].
  double step(double step_s);

  [[nodiscard]] const api::ConveyorSnapshot& state() const { return state_; }

 private:
  double max_speed_m_s_;
  double max_accel_m_s2_;
  api::ConveyorSnapshot state_;
};

}  // namespace aprsim::world
