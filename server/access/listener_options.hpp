#pragma once

#include <string>
#include <vector>

#include "protocols/grpc/grpc_server.hpp"
#include "protocols/web/web_server.hpp"
#include "server/access/guards.hpp"
#include "server/config/config.hpp"
#include "world/scene/model/scene.hpp"

/// What the configuration and the scene say of the listeners that also a replay has.
namespace aprsim::server {

// Endpoints as they stand in the journal of commands.
inline constexpr api::EndpointId kGrpcEndpoint = 2;
inline constexpr api::EndpointId kWebEndpoint = 3;

/// Names of the robots, in their order.
[[nodiscard]] std::vector<std::string> robots_of(const scene::Scene& scene);
[[nodiscard]] modbus::ConveyorScaling scaling_of(const ModbusConfig& config);
/// Of a listener that takes so many connections.
[[nodiscard]] protocols::ConnectionLimits limits_of(const ConnectionsConfig& config,
                                                    std::size_t at_once);
[[nodiscard]] grpc_server::TelemetryOptions telemetry_options(const Config& config,
                                                              const Guards& guards);
/// What a picture of the cell needs besides its description.
[[nodiscard]] web::VisualDescription visual_of(const scene::Scene& scene);
[[nodiscard]] web::WebServerOptions web_options(const Config& config, const Guards& guards,
                                                const scene::Scene& scene);

}  // namespace aprsim::server
