#include "clients/wires/endpoints.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace aprsim::client {
namespace {

constexpr const char* kToken = "APRSIM_TOKEN";
constexpr std::string_view kCrclPrefix = "crcl.", kVisionPrefix = "vision.",
                           kModbusPrefix = "modbus.";

Outcome<std::uint16_t> port_of(const std::string& path, const std::string& key,
                               const nlohmann::json& value) {
  if (!value.is_number_integer() || value < 1 || value > 65535) {
    return failed(FailureKind::kUsage,
                  fmt::format("{}: \"{}\" is {}, not a port 1..65535", path, key, value.dump()));
  }
  return value.get<std::uint16_t>();
}

/// The field that a key of the ports file means; null = none.
std::uint16_t* place_of(const std::string& key, Endpoints& endpoints) {
  if (key == "grpc") return &endpoints.grpc;
  if (key == "modbus") return &endpoints.modbus;
  if (key == "modbus_tls") return &endpoints.modbus_tls;
  if (key.starts_with(kModbusPrefix)) {
    return &endpoints.modbus_servers[key.substr(kModbusPrefix.size())];
  }
  if (key.starts_with(kCrclPrefix)) return &endpoints.crcl[key.substr(kCrclPrefix.size())];
  if (key.starts_with(kVisionPrefix)) return &endpoints.vision[key.substr(kVisionPrefix.size())];
  return nullptr;
}

/// The port of a robot. Failure: lists the known robots.
Outcome<std::uint16_t> port_in(const std::map<std::string, std::uint16_t>& ports,
                               const std::string& robot) {
  const auto found = ports.find(robot);
  if (found != ports.end()) return found->second;
  std::string names;
  for (const auto& [name, port] : ports) names += (names.empty() ? "" : ", ") + name;
  return failed(FailureKind::kUsage,
                fmt::format("no robot '{}'; there is {}", robot, names.empty() ? "none" : names));
}

Outcome<std::string> read_token(const std::string& path) {
  std::string token;
  if (path.empty()) {
    if (const char* variable = std::getenv(kToken)) token = variable;
  } else if (std::ifstream in(path); !std::getline(in, token)) {
    return failed(FailureKind::kUsage, fmt::format("cannot read a token from {}", path));
  }
  const auto printable = [](char c) { return c >= ' ' && c <= '~'; };
  if (token.ends_with('\r')) token.pop_back();
  if (std::ranges::all_of(token, printable)) return token;
  // The message must not contain the token.
  return failed(FailureKind::kUsage,
                fmt::format("the token in {} is not ASCII", path.empty() ? kToken : path));
}

/// The file chosen, else the one that the variable names; empty = none.
std::string file_of(const std::string& chosen, const char* variable) {
  if (!chosen.empty()) return chosen;
  const char* named = std::getenv(variable);
  return named == nullptr ? "" : named;
}

Outcome<std::string> read_pem(const std::string& path) {
  if (path.empty()) return std::string();
  std::ifstream in(path);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (text.find("-----BEGIN ") != std::string::npos) return text;
  return failed(FailureKind::kUsage,
                in.is_open() ? path + " contains no PEM data"
                             : fmt::format("cannot read {}: {}", path, std::strerror(errno)));
}

Outcome<std::optional<Encryption>> read_encryption(const EndpointChoice& choice) {
  Encryption encryption;
  bool any = choice.tls;
  for (const auto& [file, variable, text] :
       {std::tuple(&choice.ca, "APRSIM_CA", &encryption.ca),
        std::tuple(&choice.certificate, "APRSIM_CERTIFICATE", &encryption.certificate),
        std::tuple(&choice.key, "APRSIM_KEY", &encryption.key)}) {
    auto read = read_pem(file_of(*file, variable));
    if (!read) return tl::unexpected(read.error());
    *text = std::move(*read);
    any = any || !text->empty();
  }
  if (encryption.certificate.empty() != encryption.key.empty()) {
    return failed(FailureKind::kUsage,
                  "a client certificate needs its key, and a key its certificate");
  }
  return any ? std::optional(std::move(encryption)) : std::nullopt;
}

/// The host without the brackets of an IPv6 address.
Outcome<std::string> read_host(const std::string& text) {
  const bool opens = text.starts_with('['), closes = text.ends_with(']');
  const std::string host = opens && closes ? text.substr(1, text.size() - 2) : text;
  // A colon is in IPv6 addresses only, which may have a zone (RFC 4007, section 11).
  const bool ipv6 = host.find(':') != std::string::npos;
  in6_addr address{};
  const bool valid =
      ipv6 ? inet_pton(AF_INET6, host.substr(0, host.find('%')).c_str(), &address) == 1
           : !opens && !closes && !host.empty() &&
                 host.find_first_of("[]/@ \t\r\n") == std::string::npos;
  if (opens == closes && valid) return host;
  return failed(FailureKind::kUsage,
                fmt::format("host: found '{}', expected a name or an address such as cell, "
                            "192.168.1.7, ::1 or [::1]",
                            text));
}

}  // namespace

std::string host_and_port(const std::string& host, std::uint16_t port) {
  const bool ipv6 = host.find(':') != std::string::npos;
  return ipv6 ? fmt::format("[{}]:{}", host, port) : fmt::format("{}:{}", host, port);
}

Outcome<Endpoints> read_ports_file(const std::string& path) {
  std::ifstream in(path);
  if (!in) {
    return failed(FailureKind::kUsage,
                  fmt::format("cannot read the ports file {}; is aprsimd running?", path));
  }
  const auto json = nlohmann::json::parse(in, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) {
    return failed(FailureKind::kUsage, path + " is not a ports file: no JSON object");
  }
  Endpoints endpoints;
  endpoints.crcl.clear();
  endpoints.vision.clear();
  for (const auto& [key, value] : json.items()) {
    std::uint16_t* const place = place_of(key, endpoints);
    if (place == nullptr) continue;
    const auto port = port_of(path, key, value);
    if (!port) return tl::unexpected(port.error());
    *place = *port;
  }
  return endpoints;
}

std::string ports_file_of(const EndpointChoice& choice) {
  return file_of(choice.ports_file, "APRSIM_PORTS_FILE");
}

Outcome<Endpoints> find_endpoints(const EndpointChoice& choice) {
  const std::string file = ports_file_of(choice);
  Endpoints endpoints;
  if (!file.empty()) {
    auto read = read_ports_file(file);
    if (!read) return read;
    endpoints = std::move(*read);
  }
  auto token = read_token(choice.token_file);
  if (!token) return tl::unexpected(token.error());
  endpoints.token = std::move(*token);
  auto encryption = read_encryption(choice);
  if (!encryption) return tl::unexpected(encryption.error());
  endpoints.encryption = std::move(*encryption);
  if (!choice.host.empty()) {
    auto host = read_host(choice.host);
    if (!host) return tl::unexpected(host.error());
    endpoints.host = std::move(*host);
  }
  if (choice.grpc) endpoints.grpc = *choice.grpc;
  if (choice.modbus) endpoints.modbus = endpoints.modbus_tls = *choice.modbus;
  for (const auto& [robot, port] : choice.crcl) endpoints.crcl[robot] = port;
  return endpoints;
}

Outcome<std::uint16_t> crcl_port(const Endpoints& endpoints, const std::string& robot) {
  return port_in(endpoints.crcl, robot);
}

Outcome<std::uint16_t> vision_port(const Endpoints& endpoints, const std::string& robot) {
  return port_in(endpoints.vision, robot);
}

}  // namespace aprsim::client
