#pragma once

#include <vector>

#include "world/api/commands/signal_command.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/base/result.hpp"

namespace aprsim::devices {

/// Whether all settings are of inputs that there are, with values that they take. Errors name the
/// field, the value and what is expected: kNotFound for an unknown device or signal,
/// kInvalidArgument for a signal that is no input, a value out of range, and too many settings.
/// Thread: any.
[[nodiscard]] Result<void> check_settings(const api::SetSignals& command,
                                          const std::vector<api::DeviceDescription>& devices);

}  // namespace aprsim::devices
