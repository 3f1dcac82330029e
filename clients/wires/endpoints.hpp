#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// The encryption of gRPC and Modbus Security: texts in PEM.
struct Encryption {
  std::string ca = {};           ///< authorities of the daemon's certificate; empty = the system's
  std::string certificate = {};  ///< the client's own; empty = none
  std::string key = {};
};

/// The addresses of the daemon's listeners, and the credentials.
struct Endpoints {
  std::string host = "127.0.0.1";  ///< name or address, without brackets
  std::uint16_t grpc = 50051;
  std::uint16_t modbus = 1502;
  std::uint16_t modbus_tls = 802;  ///< Modbus Security
  std::map<std::string, std::uint16_t> crcl{{"fanuc", 64444}, {"motoman", 64445}};  ///< by robot
  std::map<std::string, std::uint16_t> vision{{"fanuc", 4000}, {"motoman", 4001}};  ///< by robot
  std::map<std::string, std::uint16_t> modbus_servers = {};  ///< of the scene, by name
  std::string token = {};                                    ///< for gRPC; empty = none
  std::optional<Encryption> encryption = {};                 ///< absent = gRPC is not encrypted
};

/// A user's choice of endpoints. Absent settings come from environment variables, then defaults.
struct EndpointChoice {
  std::string ports_file;  ///< written by aprsimd; empty = the one that APRSIM_PORTS_FILE names
  std::string host;        ///< name or address, IPv6 also in brackets; empty = 127.0.0.1
  std::string token_file;  ///< its first line is the token; empty = APRSIM_TOKEN is
  bool tls = false;        ///< encrypt even if none of the files below is given
  /// Files in PEM; empty = those that APRSIM_CA, APRSIM_CERTIFICATE and APRSIM_KEY name.
  std::string ca, certificate, key;
  std::optional<std::uint16_t> grpc;
  std::optional<std::uint16_t> modbus;  ///< with and without encryption
  std::map<std::string, std::uint16_t> crcl;
};

/// "HOST:PORT", with brackets around an IPv6 address (RFC 3986, section 3.2.2).
[[nodiscard]] std::string host_and_port(const std::string& host, std::uint16_t port);

/// Reads a ports file as aprsimd writes it: {"crcl.NAME": N, "vision.NAME": N, "modbus": N,
/// "grpc": N, ...}. Only the robots it names exist; other keys are ignored. Failures: kUsage.
[[nodiscard]] Outcome<Endpoints> read_ports_file(const std::string& path);

/// The ports file chosen, else the one that APRSIM_PORTS_FILE names; empty = none.
[[nodiscard]] std::string ports_file_of(const EndpointChoice& choice);

/// The ports file chosen, else the one that APRSIM_PORTS_FILE names, else the default ports; then
/// each single choice over it, the token and the encryption. Failures: kUsage, for files that
/// cannot be read and for a host that is none.
[[nodiscard]] Outcome<Endpoints> find_endpoints(const EndpointChoice& choice);

/// Port of a robot's CRCL server; the failure (kUsage) lists the robots there are.
[[nodiscard]] Outcome<std::uint16_t> crcl_port(const Endpoints& endpoints,
                                               const std::string& robot);

/// Port of a robot's vision feed; the failure (kUsage) lists the robots that have one.
[[nodiscard]] Outcome<std::uint16_t> vision_port(const Endpoints& endpoints,
                                                 const std::string& robot);

}  // namespace aprsim::client
