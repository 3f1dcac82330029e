#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/crcl_config.hpp"
#include "world/api/error.hpp"

/// The daemon's configuration: defaults here, then a YAML file, then the command line.
namespace aprsim::server {

/// What the wall clock has to do with simulated time.
struct Speed {
  enum class Mode { kFactor, kMax, kStepped };
  Mode mode = Mode::kFactor;
  double factor = 1.0;  ///< of real time, for kFactor
};

struct ModbusConfig {
  std::string address = "127.0.0.1";
  std::uint16_t port = 1502;
  std::uint32_t max_connections = 128;
  bool forward_is_one = true;               ///< register 0x8001: which value means forward
  double full_scale_m_s = 0.32768;          ///< belt speed that 32768 in register 0x8002 stands for
  std::vector<std::string> allow;           ///< networks or addresses served; none = everybody
  std::vector<std::uint8_t> unit_ids;       ///< unit ids that are ours; none = any
  bool read_only = false;                   ///< refuse the functions that write
  double max_requests_per_s = 0;            ///< of one connection; 0 = no limit
  std::uint32_t request_timeout_ms = 4000;  ///< for a request to arrive, for a reply to be taken
  std::uint32_t idle_timeout_ms = 0;        ///< without a request; 0 = never closed
  std::uint32_t watchdog_ms = 0;  ///< simulated; the belt stops after so long without a write
};

struct GrpcConfig {
  std::string address = "127.0.0.1";
  std::uint16_t port = 50051;
  std::uint32_t max_connections = 64;
};

/// The cameras themselves belong to the scene.
struct VisionConfig {
  std::string address = "127.0.0.1";
  /// By robot name; a robot that is not listed gets a free port.
  std::map<std::string, std::uint16_t> ports = {{"fanuc", 4000}, {"motoman", 4001}};
  std::uint32_t max_connections = 64;  ///< of each robot
  bool empty_slots = false;            ///< lines name what was not detected, too
  double repeat_s =
      0.25;  ///< wall time after which a frame without successor is sent again; <= 0.5
};

/// The web page. Its files belong to the installation.
struct WebConfig {
  bool enabled = true;  ///< --no-web turns it off
  std::string address = "127.0.0.1";
  std::uint16_t port = 8080;
  std::uint32_t max_connections = 32;
  std::uint32_t max_viewers = 24;  ///< pages that show the cell at once
  double max_rate_hz = 60;         ///< of the cell's states sent to a page
  bool control = true;             ///< false: pages may only look
  std::string token;               ///< not empty: a page needs it to command
  std::vector<std::string> hosts;  ///< names of this machine in addresses, besides localhost
};

struct Config {
  std::string scene = "aprs";
  std::optional<std::uint64_t> seed;  ///< instead of the scene's
  Speed speed;
  std::string log_level = "info";  ///< trace, debug, info, warn, error
  CrclConfig crcl;
  ModbusConfig modbus;
  GrpcConfig grpc;
  VisionConfig vision;
  WebConfig web;
};

/// Reads `file` (none when empty) and then `overrides` (dotted key, YAML value). An unknown key or
/// a wrong value is an error that reads "FILE:LINE:COLUMN: KEY: found ..., expected ...".
[[nodiscard]] Result<Config> load_config(
    const std::string& file, const std::vector<std::pair<std::string, std::string>>& overrides);

/// Every listener on a port that the system picks.
void use_free_ports(Config& config);

/// The configuration as YAML that load_config reads back to the same.
[[nodiscard]] std::string to_yaml(const Config& config);

/// Keys of the configuration that name a robot neither of `robots` nor of the shipped scenes, such
/// as "crcl.ports.fanuk": most likely a mistake.
[[nodiscard]] std::vector<std::string> keys_of_unknown_robots(
    const Config& config, const std::vector<std::string>& robots);

/// "1", "2.5", "max", "stepped".
[[nodiscard]] std::string to_text(const Speed& speed);

}  // namespace aprsim::server
