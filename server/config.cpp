#include "server/config.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "protocols/modbus/modbus_server.hpp"
#include "server/yaml_text.hpp"
#include "world/scene/yaml_reader.hpp"

namespace aprsim::server {
namespace {

std::uint16_t port_or(const yaml::Node& node, std::uint16_t fallback) {
  return static_cast<std::uint16_t>(node.integer_or(fallback, 0, kMaxPort));
}

std::uint32_t connections_or(const yaml::Node& node, std::uint32_t fallback) {
  return static_cast<std::uint32_t>(node.integer_or(fallback, 1, 1024));
}

/// At most a day.
std::uint32_t milliseconds_or(const yaml::Node& node, std::int64_t min, std::uint32_t fallback) {
  return static_cast<std::uint32_t>(node.integer_or(fallback, min, 86'400'000));
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

void read(const yaml::Node& node, ModbusConfig& modbus) {
  if (!node) return;
  const auto map =
      node.map({"address", "port", "max_connections", "forward_is_one", "full_scale_m_s", "allow",
                "unit_ids", "read_only", "max_requests_per_s", "request_timeout_ms",
                "idle_timeout_ms", "watchdog_ms"});
  modbus.address = map["address"].text_or(modbus.address);
  modbus.port = port_or(map["port"], modbus.port);
  modbus.max_connections = connections_or(map["max_connections"], modbus.max_connections);
  modbus.forward_is_one = map["forward_is_one"].boolean_or(modbus.forward_is_one);
  modbus.full_scale_m_s = map["full_scale_m_s"].number_or(modbus.full_scale_m_s, yaml::kPositive);
  for (const auto& network : map["allow"].items()) {
    modbus.allow.push_back(network.text());
    if (!protocols::is_network(modbus.allow.back())) {
      network.unexpected("an address or a network such as 192.168.1.0/24");
    }
  }
  for (const auto& unit : map["unit_ids"].items()) {
    modbus.unit_ids.push_back(static_cast<std::uint8_t>(unit.integer(0, 255)));
  }
  modbus.read_only = map["read_only"].boolean_or(modbus.read_only);
  modbus.max_requests_per_s =
      map["max_requests_per_s"].number_or(modbus.max_requests_per_s, yaml::kNotNegative);
  if (modbus.max_requests_per_s > 0 && modbus.max_requests_per_s < 1) {
    map["max_requests_per_s"].unexpected("0 (no limit) or at least 1");
  }
  modbus.request_timeout_ms =
      milliseconds_or(map["request_timeout_ms"], 10, modbus.request_timeout_ms);
  modbus.idle_timeout_ms = milliseconds_or(map["idle_timeout_ms"], 0, modbus.idle_timeout_ms);
  modbus.watchdog_ms = milliseconds_or(map["watchdog_ms"], 0, modbus.watchdog_ms);
}

void read(const yaml::Node& node, GrpcConfig& grpc) {
  if (!node) return;
  const auto map = node.map({"address", "port", "max_connections"});
  grpc.address = map["address"].text_or(grpc.address);
  grpc.port = port_or(map["port"], grpc.port);
  grpc.max_connections = connections_or(map["max_connections"], grpc.max_connections);
}

void read(const yaml::Node& node, VisionConfig& vision) {
  if (!node) return;
  const auto map = node.map({"address", "ports", "max_connections", "empty_slots", "repeat_s"});
  vision.address = map["address"].text_or(vision.address);
  for (const auto& [robot, port] : map["ports"].entries()) vision.ports[robot] = port_or(port, 0);
  vision.max_connections = connections_or(map["max_connections"], vision.max_connections);
  vision.empty_slots = map["empty_slots"].boolean_or(vision.empty_slots);
  // A frame at least every half second, as simulated cameras of APRS send; more often than a poll
  // makes no sense.
  vision.repeat_s = map["repeat_s"].number_or(vision.repeat_s, yaml::between(0.01, 0.5));
}

void read(const yaml::Node& node, WebConfig& web) {
  if (!node) return;
  const auto map = node.map({"enabled", "address", "port", "max_connections", "max_viewers",
                             "max_rate_hz", "control", "token", "hosts"});
  web.enabled = map["enabled"].boolean_or(web.enabled);
  web.address = map["address"].text_or(web.address);
  web.port = port_or(map["port"], web.port);
  web.max_connections = connections_or(map["max_connections"], web.max_connections);
  web.max_viewers = connections_or(map["max_viewers"], web.max_viewers);
  web.max_rate_hz = map["max_rate_hz"].number_or(web.max_rate_hz, yaml::between(1, 60));
  web.control = map["control"].boolean_or(web.control);
  if (const auto token = map["token"]) {
    web.token = token.text();
    // Guessing is limited to two attempts a second.
    if (web.token.size() < 8) token.error("a shorter text", "at least 8 characters");
  }
  for (const auto& host : map["hosts"].items()) web.hosts.push_back(host.text());
}

void read(const yaml::Node& root, Config& config) {
  const auto map =
      root.map({"scene", "seed", "speed", "log_level", "crcl", "modbus", "grpc", "vision", "web"});
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
  read(map["vision"], config.vision);
  read(map["web"], config.web);
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
  for (auto& [robot, port] : config.vision.ports) port = 0;
  config.modbus.port = 0;
  config.grpc.port = 0;
  config.web.port = 0;
}

std::vector<std::string> keys_of_unknown_robots(const Config& config,
                                                const std::vector<std::string>& robots) {
  const auto shipped = Config{}.crcl.ports;
  std::vector<std::string> keys;
  const auto look = [&](const char* key, const auto& named) {
    for (const auto& [robot, value] : named) {
      if (shipped.contains(robot) || std::ranges::find(robots, robot) != robots.end()) continue;
      keys.push_back(fmt::format("{}.{}", key, robot));
    }
  };
  look("crcl.ports", config.crcl.ports);
  look("crcl.robots", config.crcl.robots);
  look("vision.ports", config.vision.ports);
  return keys;
}

namespace {

std::string restrictions(const ModbusConfig& modbus) {
  std::vector<std::string> allow;
  for (const std::string& network : modbus.allow) allow.push_back('"' + network + '"');
  return fmt::format(
      "  allow: [{}]\n  unit_ids: [{}]\n  read_only: {}\n  max_requests_per_s: {}\n"
      "  request_timeout_ms: {}\n  idle_timeout_ms: {}\n  watchdog_ms: {}\n",
      fmt::join(allow, ", "), fmt::join(modbus.unit_ids, ", "), modbus.read_only,
      modbus.max_requests_per_s, modbus.request_timeout_ms, modbus.idle_timeout_ms,
      modbus.watchdog_ms);
}

std::string to_yaml(const VisionConfig& vision) {
  return fmt::format(
      "vision:\n  address: {}\n  ports:\n{}  max_connections: {}\n  empty_slots: {}\n"
      "  repeat_s: {}\n",
      scalar(vision.address), ports_text(vision.ports), vision.max_connections, vision.empty_slots,
      vision.repeat_s);
}

std::string to_yaml(const WebConfig& web) {
  std::vector<std::string> hosts;
  for (const std::string& host : web.hosts) hosts.push_back(scalar(host));
  return fmt::format(
      "web:\n  enabled: {}\n  address: {}\n  port: {}\n  max_connections: {}\n  max_viewers: {}\n"
      "  max_rate_hz: {}\n  control: {}\n{}  hosts: [{}]\n",
      web.enabled, scalar(web.address), web.port, web.max_connections, web.max_viewers,
      web.max_rate_hz, web.control, web.token.empty() ? "" : "  token: " + scalar(web.token) + "\n",
      fmt::join(hosts, ", "));
}

}  // namespace

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
  return fmt::format(
             "scene: {}\n{}speed: {}\nlog_level: {}\n"
             "{}"
             "modbus:\n  address: {}\n  port: {}\n  max_connections: {}\n  forward_is_one: {}\n"
             "  full_scale_m_s: {}\n{}"
             "grpc:\n  address: {}\n  port: {}\n  max_connections: {}\n",
             scalar(config.scene), config.seed ? fmt::format("seed: {}\n", *config.seed) : "",
             to_text(config.speed), config.log_level, to_yaml(config.crcl),
             scalar(config.modbus.address), config.modbus.port, config.modbus.max_connections,
             config.modbus.forward_is_one, config.modbus.full_scale_m_s,
             restrictions(config.modbus), scalar(config.grpc.address), config.grpc.port,
             config.grpc.max_connections) +
         to_yaml(config.vision) + to_yaml(config.web);
}

}  // namespace aprsim::server
