#include "world/cell/machines/conveyor_drive.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::world {
namespace {

constexpr double kBeltMass = 3.0;         // kg
constexpr double kBedFriction = 0.3;      // between belt and slider bed
constexpr double kGravity = 9.81;         // m/s^2
constexpr double kForcePerAmpere = 40.0;  // N/A
constexpr double kStallCurrent = 5.0;     // A, of the motor held at rest; an estimate

}  // namespace

ConveyorDrive::ConveyorDrive(const ConveyorDriveLimits& limits) : limits_(limits) {}

void ConveyorDrive::apply(const api::ConveyorCommand& command) {
  silence_s_ = 0;
  if (command.watchdog_s) watchdog_s_ = *command.watchdog_s;
  if (command.forward) state_.forward = *command.forward;
  if (command.speed_m_s) state_.speed_setting_m_s = *command.speed_m_s;
  if (command.emergency_stop) state_.emergency_stop = *command.emergency_stop;
  if (command.fault_reset) state_.fault = present_fault();
  if (present_fault() == api::DriveFault::kEmergencyStop) trip(api::DriveFault::kEmergencyStop);
  if (command.run) state_.run = *command.run && state_.fault == api::DriveFault::kNone;
}

api::DriveFault ConveyorDrive::present_fault() const {
  if (state_.emergency_stop || faults_.emergency_stop) return api::DriveFault::kEmergencyStop;
  return curtain_broken_ ? api::DriveFault::kLightCurtain : api::DriveFault::kNone;
}

void ConveyorDrive::set_light_curtain(bool broken) {
  curtain_broken_ = broken;
  if (broken && state_.fault != api::DriveFault::kEmergencyStop) {
    trip(api::DriveFault::kLightCurtain);
  }
}

void ConveyorDrive::set_faults(const BeltFaults& faults) {
  if (faults.encoder_frozen && !faults_.encoder_frozen) {
    frozen_speed_m_s_ = state_.speed_m_s;
    frozen_travel_m_ = state_.travel_m;
  }
  faults_ = faults;
  if (faults.emergency_stop) trip(api::DriveFault::kEmergencyStop);
}

api::ConveyorSnapshot ConveyorDrive::readings() const {
  api::ConveyorSnapshot out = state_;
  out.emergency_stop = out.emergency_stop || faults_.emergency_stop;
  if (faults_.encoder_frozen) {
    out.speed_m_s = frozen_speed_m_s_;
    out.travel_m = frozen_travel_m_;
  }
  return out;
}

void ConveyorDrive::trip(api::DriveFault fault) {
  state_.fault = fault;
  state_.run = false;
}

void ConveyorDrive::watch(double step_s) {
  silence_s_ += step_s;
  if (state_.run && watchdog_s_ > 0 && silence_s_ > watchdog_s_) trip(api::DriveFault::kWatchdog);
}

void ConveyorDrive::advance_clock(double step_s, std::uint64_t steps) {
  // One addition a step, as step() does: the sum has the same bits.
  for (; steps > 0; --steps) silence_s_ += step_s;
}

double ConveyorDrive::target() const {
  if (!state_.run) return 0;
  const double magnitude =
      std::min(faults_.speed_factor * state_.speed_setting_m_s, limits_.max_speed_m_s);
  return state_.forward != faults_.reversed ? magnitude : -magnitude;
}

double ConveyorDrive::next_speed(double step_s) const {
  const double now = state_.speed_m_s, wanted = target();
  const double sense = now != 0 ? std::copysign(1.0, now) : std::copysign(1.0, wanted);
  const double speed = std::abs(now), goal = std::max(wanted * sense, 0.0);
  if (speed > goal) {
    const bool emergency = state_.fault == api::DriveFault::kEmergencyStop ||
                           state_.fault == api::DriveFault::kLightCurtain;
    const double decel = emergency ? limits_.emergency_decel_m_s2 : limits_.decel_m_s2;
    return sense * std::max(speed - decel * step_s, goal);
  }
  return sense * std::min(speed + limits_.accel_m_s2 * step_s, goal);
}

double ConveyorDrive::motor_current(double accel_m_s2) const {
  const double v = state_.speed_m_s;
  const double sense = v > 0 ? 1 : v < 0 ? -1 : 0;
  const double force =
      (kBeltMass + state_.load_kg) * (accel_m_s2 + kBedFriction * kGravity * sense);
  return std::abs(force) / kForcePerAmpere;
}

double ConveyorDrive::step(double step_s) {
  watch(step_s);
  if (faults_.jammed) {
    state_.speed_m_s = 0;
    state_.motor_current_a = target() != 0 ? kStallCurrent : 0;
    return 0;
  }
  const double before = state_.speed_m_s;
  state_.speed_m_s = next_speed(step_s) + 0.0;  // no negative zero
  state_.travel_m += 0.5 * (before + state_.speed_m_s) * step_s;
  state_.motor_current_a = motor_current((state_.speed_m_s - before) / step_s);
  return faults_.surface_share * state_.speed_m_s;
}

}  // namespace aprsim::world
