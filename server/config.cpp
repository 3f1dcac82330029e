#include "server/config.hpp"

#include <charconv>
#include <limits>

#include <fmt/format.h>

#include "world/scene/yaml_reader.hpp"

namespace aprsim::server {
namespace {

constexpr std::int64_t kMaxPort = 65535;

std::uint16_t port_or(const yaml::Node& node, std::uint16_t fallback) {
  return static_cast<std::uint16_t>(node.integer_or(fallback, 0, kMaxPort));
}

std::uint32_t connections_or(const yaml::Node& node, std::uint32_t fallback) {
  return static_cast<std::uint32_t>(node.integer_or(fallback, 1, 1024));
}

void read(const yaml::Node& node, Speed& speed) {
  if (!node) return;
  const std::string text = node.text();
  if (text == "max") {
    speed.mode = Speed::Mode::kMax;
  } else if (text == "stepped") {
    speed.mode = Speed::Mode::kStepped;
  } else {
    const auto end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, speed.factor);
    if (parsed.ec != std::errc{} || parsed.ptr != end || !(speed.factor > 0) ||
        speed.factor > 1e6) {
      node.unexpected("max, stepped, or a ratio of simulated to real time > 0");
    }
  }
}

void read(const yaml::Node& node, CrclConfig& crcl) {
  if (!node) return;
  const auto map = node.map({"address", "ports", "max_connections", "length_unit", "angle_unit"});
  crcl.address = map["address"].text_or(crcl.address);
  for (const auto& [robot, port] : map["ports"].entries()) crcl.ports[robot] = port_or(port, 0);
  crcl.max_connections = connections_or(map["max_connections"], crcl.max_connections);
  if (const auto unit = map["length_unit"]) {
    const char* const names[] = {"meter", "millimeter", "inch"};
    crcl.length_unit = names[unit.word({"meter", "millimeter", "inch"})];
  }
  if (const auto unit = map["angle_unit"]) {
    const char* const names[] = {"degree", "radian"};
    crcl.angle_unit = names[unit.word({"degree", "radian"})];
  }
}

void read(const yaml::Node& node, ModbusConfig& modbus) {
  if (!node) return;
  const auto map =
      node.map({"address", "port", "max_connections", "forward_is_one", "full_scale_m_s"});
  modbus.address = map["address"].text_or(modbus.address);
  modbus.port = port_or(map["port"], modbus.port);
  modbus.max_connections = connections_or(map["max_connections"], modbus.max_connections);
  modbus.forward_is_one = map["forward_is_one"].boolean_or(modbus.forward_is_one);
  modbus.full_scale_m_s = map["full_scale_m_s"].number_or(modbus.full_scale_m_s, yaml::kPositive);
}

void read(const yaml::Node& node, GrpcConfig& grpc) {
  if (!node) return;
  const auto map = node.map({"address", "port", "max_connections"});
  grpc.address = map["address"].text_or(grpc.address);
  grpc.port = port_or(map["port"], grpc.port);
  grpc.max_connections = connections_or(map["max_connections"], grpc.max_connections);
}

void read(const yaml::Node& root, Config& config) {
  const auto map = root.map({"scene", "seed", "speed", "log_level", "crcl", "modbus", "grpc"});
  config.scene = map["scene"].text_or(config.scene);
  if (const auto seed = map["seed"]) config.seed = static_cast<std::uint64_t>(seed.integer());
  read(map["speed"], config.speed);
  if (const auto level = map["log_level"]) {
    const char* const names[] = {"trace", "debug", "info", "warn", "error"};
    config.log_level = names[level.word({"trace", "debug", "info", "warn", "error"})];
  }
  read(map["crcl"], config.crcl);
  read(map["modbus"], config.modbus);
  read(map["grpc"], config.grpc);
}

}  // namespace

Result<Config> load_config(const std::string& file,
                           const std::vector<std::pair<std::string, std::string>>& overrides) {
  auto document =
      file.empty() ? yaml::Document::from_text("{}", "defaults") : yaml::Document::from_file(file);
  if (!document) return tl::unexpected(document.error());
  for (const auto& [key, value] : overrides) {
    if (auto ok = document->set(key, value, "--set " + key); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  Config config;
  read(document->root(), config);
  if (document->error()) return tl::unexpected(*document->error());
  return config;
}

void use_free_ports(Config& config) {
  for (auto& [robot, port] : config.crcl.ports) port = 0;
  config.modbus.port = 0;
  config.grpc.port = 0;
}

std::string to_text(const Speed& speed) {
  switch (speed.mode) {
    case Speed::Mode::kMax:
      return "max";
    case Speed::Mode::kStepped:
      return "stepped";
    case Speed::Mode::kFactor:
      break;
  }
  return fmt::format("{}", speed.factor);
}

std::string to_yaml(const Config& config) {
  std::string ports;
  for (const auto& [robot, port] : config.crcl.ports)
    ports += fmt::format("    {}: {}\n", robot, port);
  return fmt::format(
      "scene: {}\n{}speed: {}\nlog_level: {}\n"
      "crcl:\n  address: {}\n  ports:\n{}  max_connections: {}\n  length_unit: {}\n"
      "  angle_unit: {}\n"
      "modbus:\n  address: {}\n  port: {}\n  max_connections: {}\n  forward_is_one: {}\n"
      "  full_scale_m_s: {}\n"
      "grpc:\n  address: {}\n  port: {}\n  max_connections: {}\n",
      config.scene, config.seed ? fmt::format("seed: {}\n", *config.seed) : "",
      to_text(config.speed), config.log_level, config.crcl.address, ports,
      config.crcl.max_connections, config.crcl.length_unit, config.crcl.angle_unit,
      config.modbus.address, config.modbus.port, config.modbus.max_connections,
      config.modbus.forward_is_one, config.modbus.full_scale_m_s, config.grpc.address,
      config.grpc.port, config.grpc.max_connections);
}

}  // namespace aprsim::server
