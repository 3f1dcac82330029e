#pragma once

#include "modbus/request_bytes.hpp"

namespace aprsim::modbus::testing {

using namespace aprsim::modbus::conformance;

}  // namespace aprsim::modbus::testing
