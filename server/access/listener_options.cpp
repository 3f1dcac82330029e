#include "server/access/listener_options.hpp"

#include <filesystem>
#include <utility>

#include "server/config/version.hpp"
#include "world/base/process/own_programs.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {

/// Of a listener that takes so many connections.
protocols::ConnectionLimits limits_of(const ConnectionsConfig& config, std::size_t at_once) {
  return {.at_once = at_once,
          .per_address = config.per_address,
          .yield_after = std::chrono::milliseconds(config.yield_after_ms)};
}

std::vector<std::string> robots_of(const scene::Scene& scene) {
  std::vector<std::string> robots;
  for (const auto& robot : scene.robots) robots.push_back(robot.name);
  return robots;
}

namespace {

web::RobotVisual visual_of(const scene::Robot& robot) {
  const scene::Gripper& gripper = robot.gripper;
  return {.pad_height_m = gripper.pad_height_m,
          .pad_width_m = gripper.pad_width_m,
          .pad_depth_m = gripper.pad_depth_m,
          .v_half_angle_rad = gripper.pad == scene::PadShape::kV ? gripper.v_half_angle_rad : 0,
          .palm_size = gripper.palm_size,
          .camera_V = robot.vision.camera_V,
          .area_min = robot.vision.area_min,
          .area_max = robot.vision.area_max};
}

}  // namespace

web::VisualDescription visual_of(const scene::Scene& scene) {
  web::VisualDescription visual;
  for (const auto& box : scene.fixed) visual.fixed.push_back({box.name, box.size, box.X_WS});
  for (const auto& robot : scene.robots) visual.robots.push_back(visual_of(robot));
  for (const auto& [name, gear] : scene.gear_types) {
    visual.gears.push_back({name, gear.hub_top_radius_m, gear.hub_bottom_radius_m,
                            gear.hub_height_m, gear.teeth_outer_radius_m});
  }
  for (const auto& [name, tray] : scene.tray_types) {
    auto& out = visual.trays.emplace_back();
    out.type = name;
    for (const auto& slot : tray.slots) {
      out.pockets.push_back(
          {slot.pocket.top_radius_m, slot.pocket.floor_radius_m, slot.pocket.depth_m});
    }
  }
  return visual;
}

modbus::ConveyorScaling scaling_of(const ModbusConfig& config) {
  return {.full_scale_m_s = config.full_scale_m_s, .one_is_forward = config.forward_is_one};
}

web::WebServerOptions web_options(const Config& config, const Guards& guards,
                                  const scene::Scene& scene) {
  web::WebServerOptions options;
  options.bind_address = config.web.address;
  options.port = config.web.port;
  options.limits = limits_of(config.connections, config.web.max_connections);
  options.max_viewers = config.web.max_viewers;
  options.max_rate_hz = config.web.max_rate_hz;
  options.control = config.web.control;
  options.hosts = config.web.hosts;
  options.assets = process::web_directory();
  for (const auto& robot : scene.robots) options.models.emplace_back(robot.name, robot.model_file);
  options.visual = [scene](const api::CellDescription& cell) {
    if (!cell.scene_text || *cell.scene_text == scene.text) return visual_of(scene);
    const auto file = std::filesystem::path(scene.file).parent_path() / (cell.scene + ".yaml");
    const auto other =
        scene::read_edited(*cell.scene_text, file.string(), scene::default_data_paths());
    return visual_of(other ? *other : scene);
  };
  options.version = kVersion;
  options.scaling = scaling_of(config.modbus);
  options.endpoint = kWebEndpoint;
  options.access = guards.access;
  options.audit = guards.audit.get();
  options.tls = guards.web_tls;
  return options;
}

grpc_server::TelemetryOptions telemetry_options(const Config& all, const Guards& guards) {
  const GrpcConfig& config = all.grpc;
  grpc_server::TelemetryOptions options;
  options.address = config.address;
  options.port = config.port;
  options.limits = limits_of(all.connections, config.max_connections);
  options.access = guards.access;
  options.audit = guards.audit.get();
  options.tls = guards.grpc_tls;
  options.endpoint = kGrpcEndpoint;
  return options;
}

}  // namespace aprsim::server
