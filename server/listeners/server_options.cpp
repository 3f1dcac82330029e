#include "server/listeners/server_options.hpp"

#include <chrono>
#include <cmath>
#include <filesystem>

#include "crcl/units.hpp"
#include "server/access/access_rules.hpp"
#include "server/config/version.hpp"
#include "server/listeners/visual_description.hpp"
#include "world/base/process/own_programs.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {
namespace {

using std::chrono::milliseconds;

/// Sets the options that all listeners have. A listener with an allow list serves its networks; the
/// others require credentials.
template <typename Own>
void configure(protocols::ListenerOptions& options, const ListenerContext& context, const Own& own,
               std::uint16_t port, api::EndpointId endpoint) {
  const ConnectionsConfig& connections = context.config.connections;
  options.address = own.address;
  options.port = port;
  options.limits = {.at_once = own.max_connections,
                    .per_address = connections.per_address,
                    .yield_after = milliseconds(connections.yield_after_ms)};
  if constexpr (requires { own.allow; }) {
    options.allow = allowed_networks(own.allow);
  } else {
    options.access = context.security.access;
    options.audit = context.security.audit.get();
  }
  options.endpoint = endpoint;
  options.trace = context.trace;
  options.refusals = context.refusals;
  options.virtual_time = context.virtual_time;
}

/// 0, a free port, for a name without a configured one.
std::uint16_t port_of(const std::map<std::string, std::uint16_t>& ports, const std::string& name) {
  const auto port = ports.find(name);
  return port == ports.end() ? std::uint16_t{0} : port->second;
}

modbus_server::RoleRules role_rules(const ModbusTlsConfig& config) {
  modbus_server::RoleRules rules;
  for (const auto& [role, rights] : config.roles) {
    rules.roles[role] = protocols::role_of(rights).value_or(protocols::Role::kNone);
  }
  rules.no_role = protocols::role_of(config.no_role).value_or(protocols::Role::kNone);
  return rules;
}

/// A port of Modbus Security: certificates, and no list of addresses, decide who is served.
protocols::ListenerOptions secure_listener(const ListenerContext& context, std::uint16_t port,
                                           api::EndpointId endpoint) {
  struct Own {
    const std::string& address;
    std::uint32_t max_connections;
  };
  const ModbusConfig& config = context.config.modbus;
  protocols::ListenerOptions options;
  configure(options, context, Own{config.tls.address, config.max_connections}, port, endpoint);
  options.tls = context.security.modbus_tls;
  return options;
}

crcl::Units units_of(const CrclRobotConfig& config) {
  crcl::Units units;
  units.length = config.length_unit == "meter"        ? crcl::LengthUnit::kMeter
                 : config.length_unit == "millimeter" ? crcl::LengthUnit::kMillimeter
                                                      : crcl::LengthUnit::kInch;
  units.angle = config.angle_unit == "degree" ? crcl::AngleUnit::kDegree : crcl::AngleUnit::kRadian;
  return units;
}

}  // namespace

std::vector<std::string> robots_of(const scene::Scene& scene) {
  std::vector<std::string> robots;
  for (const auto& robot : scene.robots) robots.push_back(robot.name);
  return robots;
}

modbus::ConveyorScaling scaling_of(const ModbusConfig& config) {
  return {.full_scale_m_s = config.full_scale_m_s, .one_is_forward = config.forward_is_one};
}

crcl_server::CrclServerOptions crcl_options(const ListenerContext& context, int index,
                                            const std::string& robot) {
  const CrclConfig& config = context.config.crcl;
  const CrclRobotConfig& own = config.of(robot);
  const auto corner = [](const std::array<double, 3>& p) { return Eigen::Vector3d(p.data()); };
  crcl_server::CrclServerOptions options;
  configure(options.listener, context, config, port_of(config.ports, robot),
            kFirstCrclEndpoint + static_cast<api::EndpointId>(index));
  options.robot = index;
  options.units = units_of(own);
  options.strict = own.strict;
  options.clamp_targets = own.clamp_targets;
  options.wait_for_end_effector = own.wait_for_end_effector;
  options.end_program_with_client = own.end_program_with_client;
  if (own.cartesian_min_m) options.cartesian_min_R = corner(*own.cartesian_min_m);
  if (own.cartesian_max_m) options.cartesian_max_R = corner(*own.cartesian_max_m);
  options.document_timeout = milliseconds(config.document_timeout_ms);
  options.idle_timeout = milliseconds(config.idle_timeout_ms);
  return options;
}

vision_server::VisionServerOptions vision_options(const ListenerContext& context, int index,
                                                  const std::string& robot) {
  const VisionConfig& config = context.config.vision;
  vision_server::VisionServerOptions options;
  configure(options.listener, context, config, port_of(config.ports, robot), 0);
  options.robot = index;
  options.empty_slots = config.empty_slots;
  options.repeat = milliseconds(std::llround(config.repeat_s * 1e3));
  return options;
}

camera_server::CameraServerOptions camera_options(const ListenerContext& context, std::size_t place,
                                                  const std::string& name) {
  constexpr std::size_t kLastPort = 65535;
  const CamerasConfig& config = context.config.cameras;
  const std::size_t port = config.port + place;
  const bool is_free = config.port == 0 || port > kLastPort;
  camera_server::CameraServerOptions options;
  configure(options.listener, context, config,
            is_free ? std::uint16_t{0} : static_cast<std::uint16_t>(port), 0);
  options.camera = name;
  if (const auto own = config.endpoints.find(name); own != config.endpoints.end()) {
    options.listener.address = own->second.address;
    options.listener.port = own->second.port;
  }
  return options;
}

simple_message::SimpleMessageOptions simple_message_options(const ListenerContext& context,
                                                            int index, const scene::Robot& robot) {
  const SimpleMessageConfig& config = context.config.simple_message;
  const scene::SimpleMessageServers& own = robot.simple_message.value();
  const auto port = [&](const std::map<std::string, std::uint16_t>& set, std::uint16_t of_scene) {
    const auto found = set.find(robot.name);
    if (found != set.end()) return found->second;
    return config.free_ports ? std::uint16_t{0} : of_scene;
  };
  simple_message::SimpleMessageOptions options;
  configure(options.listener, context, config, 0,
            kFirstSimpleMessageEndpoint + static_cast<api::EndpointId>(index));
  options.motion_port = port(config.motion, own.motion_port);
  options.state_port = port(config.state, own.state_port);
  options.gripper_port = port(config.gripper, own.gripper_port);
  options.robot = index;
  options.controller = own.controller == scene::SimpleMessageController::kMotomanFs100
                           ? simple_message::ControllerKind::kMotomanFs100
                           : simple_message::ControllerKind::kFanucKarel;
  options.joint_speed = own.joint_speed;
  options.rounding = own.cnt / 100;
  options.interpolation_clock = milliseconds(own.interpolation_ms);
  return options;
}

modbus_server::ModbusServerOptions modbus_options(const ListenerContext& context) {
  const ModbusConfig& config = context.config.modbus;
  modbus_server::ModbusServerOptions options;
  configure(options.listener, context, config, config.port, kModbusEndpoint);
  options.scaling = scaling_of(config);
  options.unit_ids = config.unit_ids;
  options.read_only = config.read_only;
  options.max_requests_per_s = config.max_requests_per_s;
  options.partial_timeout = milliseconds(config.request_timeout_ms);
  options.write_timeout = options.partial_timeout;
  options.idle_timeout = milliseconds(config.idle_timeout_ms);
  options.watchdog = milliseconds(config.watchdog_ms);
  if (context.security.modbus_tls) {
    options.secure = secure_listener(context, config.tls.port, kModbusEndpoint);
    options.roles = role_rules(config.tls);
  }
  return options;
}

modbus_server::ModbusServerOptions map_options(const ListenerContext& context, std::size_t place,
                                               const std::string& name) {
  modbus_server::ModbusServerOptions options = modbus_options(context);
  options.map = name;
  options.secure.reset();
  options.listener.port = port_of(context.config.modbus.ports, name);
  options.listener.endpoint = kFirstMapEndpoint + static_cast<api::EndpointId>(place);
  return options;
}

modbus_server::ModbusServerOptions secure_map_options(const ListenerContext& context,
                                                      std::size_t place, const std::string& name) {
  modbus_server::ModbusServerOptions options = map_options(context, place, name);
  options.listener = secure_listener(context, port_of(context.config.modbus.tls.ports, name),
                                     options.listener.endpoint);
  return options;
}

grpc_server::TelemetryOptions telemetry_options(const ListenerContext& context) {
  const GrpcConfig& config = context.config.grpc;
  grpc_server::TelemetryOptions options;
  configure(options.listener, context, config, config.port, kGrpcEndpoint);
  options.listener.tls = context.security.grpc_tls;
  return options;
}

web::RobotModels models_of(const scene::Scene& scene) {
  web::RobotModels models;
  for (const auto& robot : scene.robots) models.emplace_back(robot.name, robot.model_file);
  return models;
}

web::WebServerOptions web_options(const ListenerContext& context, const scene::Scene& scene) {
  const Config& config = context.config;
  web::WebServerOptions options;
  configure(options.listener, context, config.web, config.web.port, kWebEndpoint);
  options.listener.tls = context.security.web_tls;
  options.max_viewers = config.web.max_viewers;
  options.max_rate_hz = config.web.max_rate_hz;
  options.control = config.web.control;
  options.hosts = config.web.hosts;
  options.assets = process::web_directory();
  options.documents = process::documents_directory();
  options.models = [models = models_of(scene)] { return models; };
  options.visual = [scene](const api::CellDescription& cell) {
    if (!cell.scene_text || *cell.scene_text == scene.text) return visual_of(scene);
    const auto file = std::filesystem::path(scene.file).parent_path() / (cell.scene + ".yaml");
    const auto other =
        scene::read_edited(*cell.scene_text, file.string(), scene::default_data_paths());
    return visual_of(other ? *other : scene);
  };
  options.version = kVersion;
  options.scaling = scaling_of(config.modbus);
  return options;
}

}  // namespace aprsim::server
