#include "world/physics/gripper/gripper_actuator.hpp"

#include <utility>

namespace aprsim::physics {

GripperActuator::GripperActuator(const scene::Gripper& gripper) : settings_(gripper) {
  law_.air = {0, full_pressure(settings_)};
}

bool GripperActuator::command(double setting) {
  // A pneumatic valve has two positions; a servo takes any opening.
  const double reached = is_servo() ? setting : setting > 0.5 ? 1 : 0;
  if (std::exchange(setting_, reached) == reached) return false;
  // The integral of the old direction would push against the new one.
  law_.mimic = {};
  return true;
}

bool GripperActuator::set_force(double force_n) {
  return std::exchange(settings_.force_n, force_n) != force_n;
}

bool GripperActuator::set_wear(const GripperWear& wear) {
  if (wear == wear_) return false;
  wear_ = wear;
  return true;
}

void GripperActuator::vent() {
  law_ = {};
  law_.air = {0, 0};
}

bool GripperActuator::is_at_full_force() const {
  return is_servo() || air_is_steady(settings_, is_closing(), law_.air);
}

std::array<FingerDrive, 2> GripperActuator::advance(const std::array<FingerMotion, 2>& motion,
                                                    double closed_m, double step_s) {
  // Wear slows the fingers, it does not weaken them.
  auto drives = is_servo() ? servo_drives(settings_, stop_travel_m(closed_m), motion)
                           : finger_drives(settings_, is_closing(), motion, closed_m, step_s, law_);
  for (std::size_t i = 0; i < 2; ++i) drives[i].speed_m_s *= wear_.finger_speed[i];
  return drives;
}

void GripperActuator::restore(const State& state) {
  setting_ = state.setting;
  settings_.force_n = state.force_n;
  law_ = state.law;
  wear_ = state.wear;
}

}  // namespace aprsim::physics
