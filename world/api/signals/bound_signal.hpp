#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "world/api/commands/command.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/api/signals/signal_table.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"

namespace aprsim::api {

/// The things of a cell that have signals.
struct SignalSources {
  std::optional<double> belt_max_m_s;  ///< absent = the cell has no belt
  bool light_curtain = false;
  std::vector<std::string> photo_eyes, robots;
  std::vector<DeviceDescription> devices;
  bool devices_are_made = true;  ///< false: of devices only the names are known
};
[[nodiscard]] SignalSources signal_sources(const CellDescription& cell);

/// A signal of a cell.
struct BoundSignal {
  const SignalInfo* info = nullptr;
  std::size_t index = 0;       ///< of the photo-eye, robot or device
  std::size_t number = 0;      ///< of a device's signal
  std::string device, signal;  ///< names, of a device
  bool writable = false;
  std::string unit;
  // Its range, as far as it is known.
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool has_range() const { return std::isfinite(min) && std::isfinite(max); }
};

/// Whether the name can only be that of a device's signal.
[[nodiscard]] bool is_device_signal(const std::string& name);

/// The signal with this name. Error: kNotFound with the field "signal" and the names that there
/// are.
[[nodiscard]] Result<BoundSignal> bind_signal(const std::string& name,
                                              const SignalSources& sources);

/// Value of the signal; 0 where the snapshot does not have it. Thread: any.
[[nodiscard]] double value_of(const BoundSignal& signal, const Snapshot& snapshot);

/// Commands that set signals.
struct SignalCommands {
  ConveyorCommand belt;
  SetSignals devices;
};
/// Adds a new value, which must be in the range of a writable signal.
void set_signal(const BoundSignal& signal, double value, SignalCommands& commands);

}  // namespace aprsim::api
