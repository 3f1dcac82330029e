#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace aprsim::api {

/// The new value of an input of a device, in the unit of the input.
struct SignalSetting {
  std::string device, signal;  ///< names
  double value = 0;

  bool operator==(const SignalSetting&) const = default;
};

/// Settings in one command; one request of Modbus may have as many.
inline constexpr std::size_t kMaxSignalSettings = 2048;

/// Sets inputs of devices between two steps: all of them, or none. The last setting of an input is
/// the one that stays.
struct SetSignals {
  std::vector<SignalSetting> settings;
};

}  // namespace aprsim::api
