#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// How gRPC is encrypted: texts in PEM.
struct Encryption {
  std::string ca = {};           ///< authorities of the daemon's certificate; empty = the system's
  std::string certificate = {};  ///< the client's own; empty = none
  std::string key = {};
};

/// Where the daemon's listeners are.
struct Endpoints {
  std::string host = "127.0.0.1";
  std::uint16_t grpc = 50051;
  std::uint16_t modbus = 1502;
  std::map<std::string, std::uint16_t> crcl{{"fanuc", 64444}, {"motoman", 64445}};  ///< by robot
  std::string token = {};                     ///< for gRPC; empty = none
  std::optional<Encryption> encryption = {};  ///< of gRPC; absent = it is not encrypted
};

/// What the user said about where they are.
struct EndpointChoice {
  std::string ports_file;  ///< empty = none
  std::string host;        ///< empty = 127.0.0.1
  std::string token_file;  ///< its first line is the token; empty = APRSIM_TOKEN is
  bool tls = false;        ///< encrypted also where no file says so
  /// Files in PEM; empty = those that APRSIM_CA, APRSIM_CERTIFICATE and APRSIM_KEY name.
  std::string ca, certificate, key;
  std::optional<std::uint16_t> grpc, modbus;
  std::map<std::string, std::uint16_t> crcl;
};

/// Reads a ports file as aprsimd writes it: {"crcl.NAME": N, "modbus": N, "grpc": N, ...}. Only
/// the robots it names exist; other keys are ignored.
[[nodiscard]] Outcome<Endpoints> read_ports_file(const std::string& path);

/// The ports file chosen, else the one that APRSIM_PORTS_FILE names; empty = none.
[[nodiscard]] std::string ports_file_of(const EndpointChoice& choice);

/// The ports file chosen, else the one that APRSIM_PORTS_FILE names, else the default ports; then
/// each single choice over it, the token and the encryption.
[[nodiscard]] Outcome<Endpoints> find_endpoints(const EndpointChoice& choice);

/// Port of a robot's CRCL server; the failure lists the robots there are.
[[nodiscard]] Outcome<std::uint16_t> crcl_port(const Endpoints& endpoints,
                                               const std::string& robot);

}  // namespace aprsim::client
