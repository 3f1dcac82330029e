#pragma once

#include <string>
#include <vector>

#include "protocols/cameras/camera_server.hpp"
#include "protocols/crcl/crcl_server.hpp"
#include "protocols/grpc/grpc_server.hpp"
#include "protocols/modbus/modbus_server.hpp"
#include "protocols/simple_message/simple_message_server.hpp"
#include "protocols/vision/vision_server.hpp"
#include "protocols/web/web_server.hpp"
#include "server/access/security_context.hpp"
#include "server/config/config.hpp"
#include "server/listeners/endpoints.hpp"
#include "world/scene/model/scene.hpp"

/// Options of the servers by configuration and scene.
namespace aprsim::server {

/// Objects that all listeners of a daemon share; they outlive the listeners.
struct ListenerContext {
  const Config& config;
  const SecurityContext& security;
  protocols::WireTrace* trace = nullptr;       ///< null = the wires are not recorded
  protocols::RefusalSink* refusals = nullptr;  ///< null = rejections are not recorded
  api::VirtualTime* virtual_time = nullptr;    ///< null = the wall clock passes time
};

/// Names of the robots in the order of the scene.
[[nodiscard]] std::vector<std::string> robots_of(const scene::Scene& scene);
[[nodiscard]] modbus::ConveyorScaling scaling_of(const ModbusConfig& config);

/// Options for the robot with this index and name.
[[nodiscard]] crcl_server::CrclServerOptions crcl_options(const ListenerContext& context, int index,
                                                          const std::string& robot);
[[nodiscard]] vision_server::VisionServerOptions vision_options(const ListenerContext& context,
                                                                int index,
                                                                const std::string& robot);
/// For the camera with this name at this place in the scene. A port beyond 65535 is a free one.
[[nodiscard]] camera_server::CameraServerOptions camera_options(const ListenerContext& context,
                                                                std::size_t place,
                                                                const std::string& name);
/// For a robot whose scene has Simple Message.
[[nodiscard]] simple_message::SimpleMessageOptions simple_message_options(
    const ListenerContext& context, int index, const scene::Robot& robot);
[[nodiscard]] modbus_server::ModbusServerOptions modbus_options(const ListenerContext& context);
/// For the Modbus server with this name at this place in the scene.
[[nodiscard]] modbus_server::ModbusServerOptions map_options(const ListenerContext& context,
                                                             std::size_t place,
                                                             const std::string& name);
/// For the port of Modbus Security of that server; only where Modbus Security is configured.
[[nodiscard]] modbus_server::ModbusServerOptions secure_map_options(const ListenerContext& context,
                                                                    std::size_t place,
                                                                    const std::string& name);
[[nodiscard]] grpc_server::TelemetryOptions telemetry_options(const ListenerContext& context);
/// The names and models of a scene's robots.
[[nodiscard]] web::RobotModels models_of(const scene::Scene& scene);
/// For a cell that begins with this scene.
[[nodiscard]] web::WebServerOptions web_options(const ListenerContext& context,
                                                const scene::Scene& scene);

}  // namespace aprsim::server
