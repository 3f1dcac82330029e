#include "world/conveyor_drive.hpp"

#include <algorithm>

namespace aprsim::world {

ConveyorDrive::ConveyorDrive(double max_speed_m_s, double max_accel_m_s2)
    : max_speed_m_s_(max_speed_m_s), max_accel_m_s2_(max_accel_m_s2) {}

void ConveyorDrive::take(const api::ConveyorCommand& command) {
  if (command.run) state_.run = *command.run;
  if (command.forward) state_.forward = *command.forward;
  if (command.speed_m_s) state_.speed_setting_m_s = *command.speed_m_s;
}

double ConveyorDrive::step(double step_s) {
  const double magnitude = state_.run ? std::min(state_.speed_setting_m_s, max_speed_m_s_) : 0.0;
  const double target = state_.forward ? magnitude : -magnitude;
  const double most = max_accel_m_s2_ * step_s;
  const double before = state_.speed_m_s;
  state_.speed_m_s = before + std::clamp(target - before, -most, most);
  state_.travel_m += 0.5 * (before + state_.speed_m_s) * step_s;
  return state_.speed_m_s;
}

}  // namespace aprsim::world
