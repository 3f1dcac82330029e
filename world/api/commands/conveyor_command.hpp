#pragma once

#include <optional>

namespace aprsim::api {

/// Sets inputs of the drive; absent ones keep their values. Every command feeds the watchdog.
struct ConveyorCommand {
  std::optional<bool> run;             ///< true is ignored while a fault is held
  std::optional<bool> forward;         ///< true = along the belt's +x axis
  std::optional<double> speed_m_s;     ///< magnitude, >= 0
  std::optional<bool> emergency_stop;  ///< true engages (and holds a fault), false releases
  bool fault_reset = false;            ///< clears a held fault unless its cause persists
  /// The drive trips if it is commanded to run and receives no command for so long, in simulated
  /// time; 0 = never.
  std::optional<double> watchdog_s;

  bool operator==(const ConveyorCommand&) const = default;
};

}  // namespace aprsim::api
