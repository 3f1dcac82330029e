#pragma once

#include "world/api/commands/command.hpp"

namespace aprsim::server {

// Endpoint numbers in the journal; those of robots count up from the first.
inline constexpr api::EndpointId kModbusEndpoint = 1;
inline constexpr api::EndpointId kGrpcEndpoint = 2;
inline constexpr api::EndpointId kWebEndpoint = 3;
inline constexpr api::EndpointId kFirstCrclEndpoint = 16;
inline constexpr api::EndpointId kFirstSimpleMessageEndpoint = 4096;
/// The first of the Modbus servers that a scene describes; they count up in their order.
inline constexpr api::EndpointId kFirstMapEndpoint = 8192;

}  // namespace aprsim::server
