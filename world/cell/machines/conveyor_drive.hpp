#pragma once

#include <cstdint>
#include <optional>

#include "world/api/commands/conveyor_command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/faults/belt_faults.hpp"

namespace aprsim::world {

struct ConveyorDriveLimits {
  double max_speed_m_s = 0;
  double accel_m_s2 = 0;
  double decel_m_s2 = 0;            ///< of stopping and slowing down
  double emergency_decel_m_s2 = 0;  ///< of an emergency stop
};

/// The belt's drive: inputs (run, direction, speed, emergency stop, reset), and one signed speed
/// that follows them on ramps. A change of direction brakes to zero first.
///
/// A fault clears `run` and keeps it clear until it is reset; after that the drive waits for a new
/// run command. Emergency stop: brakes on its own ramp; can be reset once the input is released.
/// Light curtain: as an emergency stop; can be reset once the curtain is clear. Watchdog: an
/// ordinary stop; can be reset at once.
///
/// Motor current: I = |F| / 40 N/A with F = (m_belt + load) (a + mu g sign(v)), m_belt = 3 kg of
/// moving belt, mu = 0.3 between belt and slider bed. The figures are estimates, not from
/// a data sheet. Thread: sim.
class ConveyorDrive {
 public:
  explicit ConveyorDrive(const ConveyorDriveLimits& limits);

  void apply(const api::ConveyorCommand& command);
  /// Sets the mass on the belt [kg].
  void set_load(double load_kg) { state_.load_kg = load_kg; }
  /// Whether the light curtain is broken, from now on; for a drive that is to stop then.
  void set_light_curtain(bool broken);
  /// From now on.
  void set_faults(const BeltFaults& faults);
  /// Advances by `step_s` and returns the speed of the belt's surface at its end [m/s].
  double step(double step_s);
  /// Whether a time is bound to come at which it stops on its own.
  [[nodiscard]] bool awaits_time() const { return state_.run && watchdog_s_ > 0; }
  /// Advances only its clock, of a drive at rest.
  void advance_clock(double step_s, std::uint64_t steps);

  /// State of the belt without the photo-eyes.
  [[nodiscard]] const api::ConveyorSnapshot& state() const { return state_; }
  /// The same as the drive reports it: a frozen encoder repeats its reading.
  [[nodiscard]] api::ConveyorSnapshot readings() const;

  static constexpr bool kAsMany = true;  ///< as the scene has
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [limits, state, faults, frozen_speed_m_s, frozen_travel_m, curtain_broken, watchdog_s,
           silence_s] = self;
    io(state, faults, frozen_speed_m_s, frozen_travel_m, curtain_broken, watchdog_s, silence_s);
  }

 private:
  void trip(api::DriveFault fault);
  /// The fault whose cause is present.
  [[nodiscard]] api::DriveFault present_fault() const;
  void watch(double step_s);
  [[nodiscard]] double target() const;
  [[nodiscard]] double next_speed(double step_s) const;
  [[nodiscard]] double motor_current(double accel_m_s2) const;

  ConveyorDriveLimits limits_;
  api::ConveyorSnapshot state_;
  BeltFaults faults_;
  double frozen_speed_m_s_ = 0, frozen_travel_m_ = 0;  // of the encoder, when it froze
  bool curtain_broken_ = false;
  double watchdog_s_ = 0;
  double silence_s_ = 0;  // since the last command
};

}  // namespace aprsim::world
