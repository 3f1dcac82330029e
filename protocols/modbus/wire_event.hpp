#pragma once

#include <cstdint>
#include <span>

#include "protocols/record/wire_tap.hpp"

namespace aprsim::modbus_server {

/// A request or reply with its MBAP header as an event of the tap: a poll unless it writes. Source,
/// peer and time are unset. Thread: any.
[[nodiscard]] protocols::WireEvent wire_event(std::span<const std::uint8_t> adu);

}  // namespace aprsim::modbus_server
