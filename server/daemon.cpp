#include "server/daemon.hpp"

#include <chrono>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "crcl/units.hpp"
#include "protocols/crcl/crcl_server.hpp"
#include "protocols/modbus/modbus_server.hpp"
#include "protocols/telemetry/telemetry_server.hpp"
#include "protocols/vision/vision_server.hpp"
#include "world/simulation.hpp"

namespace aprsim::server {
namespace {

// Endpoints as they stand in the journal of commands; robots count up from the first.
constexpr api::EndpointId kModbusEndpoint = 1;
constexpr api::EndpointId kGrpcEndpoint = 2;
constexpr api::EndpointId kFirstCrclEndpoint = 16;

world::SimulationOptions simulation_options(const Config& config, const scene::Scene& scene) {
  world::SimulationOptions options;
  options.seed = config.seed.value_or(scene.seed);
  options.paused = config.speed.mode == Speed::Mode::kStepped;
  if (config.speed.mode == Speed::Mode::kFactor) {
    options.speed = config.speed.factor;
  } else {
    options.speed = std::nullopt;
  }
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

protocols::CrclServerOptions crcl_options(const CrclConfig& config, const std::string& robot,
                                          int index) {
  protocols::CrclServerOptions options;
  options.bind_address = config.address;
  const auto port = config.ports.find(robot);
  options.port = port == config.ports.end() ? 0 : port->second;
  options.robot = index;
  const CrclRobotConfig& own = config.of(robot);
  options.units = units_of(own);
  options.strict = own.strict;
  options.clamp_targets = own.clamp_targets;
  const auto corner = [](const std::array<double, 3>& p) { return Eigen::Vector3d(p.data()); };
  if (own.cartesian_min_m) options.cartesian_min_R = corner(*own.cartesian_min_m);
  if (own.cartesian_max_m) options.cartesian_max_R = corner(*own.cartesian_max_m);
  options.max_connections = config.max_connections;
  options.endpoint = kFirstCrclEndpoint + static_cast<api::EndpointId>(index);
  return options;
}

protocols::ModbusServerOptions modbus_options(const ModbusConfig& config) {
  protocols::ModbusServerOptions options;
  options.bind_address = config.address;
  options.port = config.port;
  options.max_connections = config.max_connections;
  options.scaling = {.full_scale_m_s = config.full_scale_m_s,
                     .one_is_forward = config.forward_is_one};
  options.allow = config.allow;
  options.unit_ids = config.unit_ids;
  options.read_only = config.read_only;
  options.max_requests_per_s = config.max_requests_per_s;
  options.partial_timeout = std::chrono::milliseconds(config.request_timeout_ms);
  options.write_timeout = options.partial_timeout;
  options.idle_timeout = std::chrono::milliseconds(config.idle_timeout_ms);
  options.watchdog = std::chrono::milliseconds(config.watchdog_ms);
  options.endpoint = kModbusEndpoint;
  return options;
}

protocols::TelemetryOptions telemetry_options(const GrpcConfig& config) {
  protocols::TelemetryOptions options;
  options.address = config.address;
  options.port = config.port;
  options.max_connections = static_cast<int>(config.max_connections);
  options.endpoint = kGrpcEndpoint;
  return options;
}

protocols::VisionServerOptions vision_options(const VisionConfig& config, const std::string& robot,
                                              int index) {
  protocols::VisionServerOptions options;
  options.bind_address = config.address;
  const auto port = config.ports.find(robot);
  options.port = port == config.ports.end() ? 0 : port->second;
  options.robot = index;
  options.max_connections = config.max_connections;
  options.empty_slots = config.empty_slots;
  options.repeat = std::chrono::milliseconds(std::llround(config.repeat_s * 1e3));
  return options;
}

}  // namespace

/// Listeners are declared after the simulation that they refer to, so they end before it.
class Daemon::Impl {
 public:
  Impl(const Config& config, std::shared_ptr<const scene::Scene> scene)
      : simulation_(scene, simulation_options(config, *scene)),
        modbus_(modbus_options(config.modbus), simulation_, simulation_),
        telemetry_(telemetry_options(config.grpc), simulation_, simulation_) {
    for (std::size_t i = 0; i < scene->robots.size(); ++i) {
      const std::string& name = scene->robots[i].name;
      const int index = static_cast<int>(i);
      robots_.push_back({name,
                         std::make_unique<protocols::CrclServer>(
                             crcl_options(config.crcl, name, index), simulation_, simulation_),
                         std::make_unique<protocols::VisionServer>(
                             vision_options(config.vision, name, index), simulation_)});
    }
  }

  Result<Ports> start() {
    Ports ports;
    for (auto& [name, crcl, vision] : robots_) {
      auto port = crcl->start();
      if (!port) return tl::unexpected(port.error());
      ports["crcl." + name] = *port;
      port = vision->start();
      if (!port) return tl::unexpected(port.error());
      ports["vision." + name] = *port;
    }
    auto modbus = modbus_.start();
    if (!modbus) return tl::unexpected(modbus.error());
    ports["modbus"] = *modbus;
    auto grpc = telemetry_.start();
    if (!grpc) return tl::unexpected(grpc.error());
    ports["grpc"] = *grpc;
    simulation_.start();
    return ports;
  }

  void stop() {
    for (auto& [name, crcl, vision] : robots_) {
      crcl->stop();
      vision->stop();
    }
    modbus_.stop();
    telemetry_.stop();
    simulation_.stop();
  }

 private:
  struct Robot {
    std::string name;
    std::unique_ptr<protocols::CrclServer> crcl;
    std::unique_ptr<protocols::VisionServer> vision;
  };

  world::Simulation simulation_;
  std::vector<Robot> robots_;
  protocols::ModbusServer modbus_;
  protocols::TelemetryServer telemetry_;
};

Daemon::Daemon(const Config& config, std::shared_ptr<const scene::Scene> scene)
    : impl_(std::make_unique<Impl>(config, std::move(scene))) {}
Daemon::~Daemon() = default;
Result<Ports> Daemon::start() { return impl_->start(); }
void Daemon::stop() { impl_->stop(); }

std::uint64_t needed_files(const Config& config, std::size_t robots) {
  const std::uint64_t connections =
      (config.crcl.max_connections + config.vision.max_connections) * robots +
      config.modbus.max_connections + config.grpc.max_connections;
  // Twice what the listeners may take: running out of descriptors must never come from clients.
  return 2 * connections + 64;
}

}  // namespace aprsim::server
