#pragma once

#include "aprsim/v1/faults.pb.h"
#include "clients/aprsim/fault_commands.hpp"

namespace aprsim::client {

/// What asks the daemon for a fault.
[[nodiscard]] v1::InjectFaultRequest fault_request(const FaultInjectCommand& command);

}  // namespace aprsim::client
