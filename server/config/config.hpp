#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "world/base/result.hpp"

/// The daemon's configuration: defaults here, then a YAML file, then the command line. The
/// meaning and the range of each value are in config_keys.hpp.
namespace aprsim::server {

/// Pace of simulated time by the wall clock.
struct Speed {
  enum class Mode { kFactor, kMax, kStepped };
  Mode mode = Mode::kFactor;
  double factor = 1.0;  ///< of real time, for kFactor
};

/// Clients whose requests pass simulated time.
struct TimeConfig {
  bool clients_pace = false;  ///< key mode
  std::uint32_t poll_period_ms = 25;
  std::vector<std::string> pacers;
  std::optional<std::uint32_t> grace_ms;

  /// Declared pacers are waited for, unless the key says otherwise.
  [[nodiscard]] std::uint32_t grace() const { return grace_ms.value_or(pacers.empty() ? 5000 : 0); }
};

/// How one robot's CRCL port behaves where existing servers differ.
struct CrclRobotConfig {
  std::string length_unit = "millimeter";
  std::string angle_unit = "degree";
  bool strict = false;                 ///< key validation
  std::optional<bool> clamp_targets;   ///< key out_of_range; absent = as the scene says
  bool wait_for_end_effector = false;  ///< key end_effector_done
  bool end_program_with_client = false;
  std::optional<std::array<double, 3>> cartesian_min_m, cartesian_max_m;
};

struct CrclConfig {
  std::string address = "localhost";
  std::map<std::string, std::uint16_t> ports = {{"fanuc", 64444}, {"motoman", 64445}};
  std::uint32_t max_connections = 64;
  std::vector<std::string> allow;
  std::uint32_t document_timeout_ms = 10'000;
  std::uint32_t idle_timeout_ms = 0;
  CrclRobotConfig all;                            ///< what holds for a robot that says nothing else
  std::map<std::string, CrclRobotConfig> robots;  ///< by name, complete

  [[nodiscard]] const CrclRobotConfig& of(const std::string& robot) const {
    const auto own = robots.find(robot);
    return own == robots.end() ? all : own->second;
  }
};

/// Modbus Security; none without a certificate.
struct ModbusTlsConfig {
  std::optional<std::string> certificate, key, client_ca;
  bool only_tls_1_3 = false;  ///< key min_version
  std::string address = "localhost";
  std::uint16_t port = 802;
  std::map<std::string, std::uint16_t> ports;  ///< of the servers that a scene describes, by name
  std::map<std::string, std::string> roles;    ///< rights by the role in a client's certificate
  std::string no_role = "none";                ///< rights of a certificate without a role
};

struct ModbusConfig {
  std::string address = "localhost";
  std::uint16_t port = 1502;
  std::map<std::string, std::uint16_t> ports;  ///< of the servers that a scene describes, by name
  std::uint32_t max_connections = 128;
  bool forward_is_one = true;
  double full_scale_m_s = 0.32768;
  std::vector<std::string> allow;
  std::vector<std::uint8_t> unit_ids;
  bool read_only = false;
  double max_requests_per_s = 0;
  std::uint32_t request_timeout_ms = 4000;
  std::uint32_t idle_timeout_ms = 0;
  std::uint32_t watchdog_ms = 0;
  ModbusTlsConfig tls;
};

struct GrpcConfig {
  std::string address = "localhost";
  std::uint16_t port = 50051;
  std::uint32_t max_connections = 64;
};

/// The cameras themselves belong to the scene.
struct VisionConfig {
  std::string address = "localhost";
  std::map<std::string, std::uint16_t> ports = {{"fanuc", 4000}, {"motoman", 4001}};
  std::uint32_t max_connections = 64;
  std::vector<std::string> allow;
  bool empty_slots = false;
  double repeat_s = 0.25;
};

/// An address and a port to listen on.
struct Endpoint {
  std::string address;
  std::uint16_t port = 0;  ///< 0 = one that the system picks
};

/// Pictures of the scene's cameras, one address or port each.
struct CamerasConfig {
  std::string address = "localhost";
  std::uint16_t port = 8090;                  ///< of the first camera; the others follow
  std::map<std::string, Endpoint> endpoints;  ///< of cameras that have their own, by name
  std::uint32_t max_connections = 16;
  std::uint32_t max_mb = 512;  ///< of the renderers, besides memory.max_mb
  std::vector<std::string> allow;
};

/// ROS-Industrial's Simple Message, of the robots whose scene has it.
struct SimpleMessageConfig {
  std::string address = "localhost";
  bool free_ports = false;  ///< key ports
  // Ports that are not the scene's, by robot.
  std::map<std::string, std::uint16_t> motion, state, gripper;
  std::uint32_t max_connections = 8;
  std::vector<std::string> allow;
};

/// The web page. Its files belong to the installation.
struct WebConfig {
  bool enabled = true;
  std::string address = "localhost";
  std::uint16_t port = 8080;
  std::uint32_t max_connections = 32;
  std::uint32_t max_viewers = 24;
  double max_rate_hz = 60;
  bool control = true;
  std::string token;
  std::optional<std::string> token_file;
  std::vector<std::string> hosts;
  std::optional<bool> programs;
};

/// Access over gRPC and on the page.
struct AccessConfig {
  std::optional<std::string> file, audit_file;
  bool insecure_control = false;
  bool allow_foreign_states = false;
  bool allow_anonymous_view = true;  ///< key anonymous
};

/// Encryption of gRPC and the page; none without a certificate.
struct TlsConfig {
  std::optional<std::string> certificate, key, client_ca;
  bool client_needed = false;  ///< key client_certificates
};

/// Recording of the run.
struct JournalConfig {
  std::optional<std::string> place;  ///< file or directory; absent = none
  std::uint32_t max_file_mb = 64;
  std::uint32_t memory_minutes = 10;       ///< simulated
  std::optional<std::uint32_t> memory_mb;  ///< 0 = nothing is kept in memory
};

/// Past of the run that is kept in memory for queries.
struct HistoryConfig {
  std::uint32_t minutes = 10;  ///< of simulated time; 0 = none
  std::optional<std::uint32_t> max_mb;
};

/// The memory of the daemon. Sizes that other sections leave out are shares of it: memory_shares().
struct MemoryConfig {
  std::uint32_t max_mb = 400;
  std::optional<std::uint32_t> saved_states_mb;
};

/// Limits of the connections of every listener.
struct ConnectionsConfig {
  std::uint32_t per_address = 32;
  std::uint32_t yield_after_ms = 60'000;
};

struct Config {
  std::string scene = "aprs";
  std::optional<std::uint64_t> seed;
  Speed speed;
  TimeConfig time;
  std::string log_level = "info";
  std::vector<std::string> extensions;  ///< directories
  MemoryConfig memory;
  JournalConfig journal;
  HistoryConfig history;
  ConnectionsConfig connections;
  AccessConfig access;
  TlsConfig tls;
  CrclConfig crcl;
  ModbusConfig modbus;
  GrpcConfig grpc;
  VisionConfig vision;
  CamerasConfig cameras;
  SimpleMessageConfig simple_message;
  WebConfig web;
};

/// Reads `file` (none when empty) and then `overrides` (dotted key, YAML value). An unknown key or
/// a wrong value is an error that reads "FILE:LINE:COLUMN: KEY: found ..., expected ...".
[[nodiscard]] Result<Config> load_config(
    const std::string& file, const std::vector<std::pair<std::string, std::string>>& overrides);

/// The same from what to_yaml() has written; empty = all defaults.
[[nodiscard]] Result<Config> read_config(const std::string& text);

/// The configuration as YAML that load_config reads back to the same, secrets left out.
[[nodiscard]] std::string to_yaml(Config config);

/// Every key with its present value as in KEY=VALUE, what it means and what it accepts.
[[nodiscard]] std::string key_list(Config config);

/// Every listener on a port that the system picks.
void use_free_ports(Config& config);

/// Keys of the configuration that name a robot neither of `robots` nor of the shipped scenes, such
/// as "crcl.ports.fanuk": most likely a mistake.
[[nodiscard]] std::vector<std::string> keys_of_unknown_robots(
    Config config, const std::vector<std::string>& robots);

/// Error: `time.pacers` names a robot that is none of `robots`, for whom time would wait for ever.
[[nodiscard]] Result<void> check_pacers(const TimeConfig& time,
                                        const std::vector<std::string>& robots);

/// "1", "2.5", "max", "stepped".
[[nodiscard]] std::string to_text(const Speed& speed);

}  // namespace aprsim::server
