#pragma once

#include <map>
#include <optional>
#include <string>

#include "aprsim/v1/faults.pb.h"
#include "world/api/faults/fault_when.hpp"

namespace aprsim::client {

/// A fault to inject, from a command line.
struct FaultInjectCommand {
  std::string kind;
  std::string target;                        ///< as the kind says; empty = none
  std::map<std::string, double> parameters;  ///< SI
  std::optional<double> at_s;                ///< simulated time since the last reset
  std::optional<faults::FaultWhen> when;     ///< never with at_s
  std::optional<double> for_s;               ///< absent = until it is ended
};

/// The request for a fault.
[[nodiscard]] v1::InjectFaultRequest fault_request(const FaultInjectCommand& command);

}  // namespace aprsim::client
