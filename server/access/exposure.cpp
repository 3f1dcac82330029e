#include "server/access/exposure.hpp"

#include <array>
#include <ifaddrs.h>
#include <memory>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "protocols/access/peer_address.hpp"
#include "server/access/access_rules.hpp"

namespace aprsim::server {
namespace {

bool is_link_local(const sockaddr& address) {
  return address.sa_family == AF_INET6 &&
         IN6_IS_ADDR_LINKLOCAL(&reinterpret_cast<const sockaddr_in6&>(address).sin6_addr);
}

/// Addresses of the active interfaces without the loopback; those of IPv6 if wanted.
std::vector<std::string> interface_addresses(bool v6) {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(first, &freeifaddrs);
  std::vector<std::string> all;
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
    const sockaddr* address = one->ifa_addr;
    if (address == nullptr || (one->ifa_flags & IFF_UP) == 0U) continue;
    if ((one->ifa_flags & IFF_LOOPBACK) != 0U || is_link_local(*address)) continue;
    if (address->sa_family != AF_INET && !(v6 && address->sa_family == AF_INET6)) continue;
    const socklen_t size =
        address->sa_family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
    std::array<char, NI_MAXHOST> text{};
    if (getnameinfo(address, size, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) == 0) {
      all.emplace_back(text.data());
    }
  }
  return all;
}

/// Permissions over gRPC and on the page.
std::string by_credentials(const Config& config, bool read_only) {
  const bool asks = asks_for_credentials(config);
  const std::string holder = "holders of a token or certificate may ";
  std::string who = config.access.allow_anonymous_view ? "anyone may view"
                    : asks                             ? holder + "view"
                                                       : "no other machine may view";
  if (config.access.insecure_control && !read_only) {
    who = "anyone may command the cell (access.insecure_control)";
  } else if (read_only || !asks) {
    who += ", nobody may command";
  } else {
    who += ", " + holder + "command according to their role";
  }
  return who + (config.tls.certificate ? "" : "; not encrypted");
}

/// Permissions of listeners without credentials.
std::string by_address(const std::vector<std::string>& allow, const std::string& key,
                       const std::string& may) {
  return allow.empty() ? "no other machine is served (" + key + " is empty)"
                       : "addresses in " + key + " " + may;
}

struct Listener {
  std::string address, who;
};

Listener listener_of(const std::string& name, const Config& config) {
  if (name.starts_with("crcl.")) {
    return {config.crcl.address,
            by_address(config.crcl.allow, "crcl.allow", "may command the robot")};
  }
  if (name.starts_with("vision.")) {
    return {config.vision.address,
            by_address(config.vision.allow, "vision.allow", "may view, nobody may command")};
  }
  if (name.starts_with("camera.")) {
    const auto own = config.cameras.endpoints.find(name.substr(name.find('.') + 1));
    return {own == config.cameras.endpoints.end() ? config.cameras.address : own->second.address,
            by_address(config.cameras.allow, "cameras.allow", "may view, nobody may command")};
  }
  if (name.starts_with("motion.") || name.starts_with("state.") || name.starts_with("gripper.")) {
    return {
        config.simple_message.address,
        by_address(config.simple_message.allow, "simple_message.allow", "may command the robot")};
  }
  if (name == "modbus_tls" || name.starts_with("modbus_tls.")) {
    return {config.modbus.tls.address,
            std::string("holders of a certificate of modbus.tls.client_ca may ") +
                (config.modbus.read_only ? "view" : "view or command") + " by their role"};
  }
  if (name.starts_with("modbus.")) {
    return {config.modbus.address,
            by_address(config.modbus.allow, "modbus.allow",
                       config.modbus.read_only ? "may view, nobody may command"
                                               : "may command belt and devices")};
  }
  if (name == "modbus") {
    return {config.modbus.address,
            by_address(
                config.modbus.allow, "modbus.allow",
                config.modbus.read_only ? "may view, nobody may command" : "may command the belt")};
  }
  if (name == "grpc") return {config.grpc.address, by_credentials(config, false)};
  return {config.web.address,
          by_credentials(config, !config.web.control) +
              (may_start_programs(config) ? "; admins may start programs" : "")};
}

}  // namespace

std::vector<std::string> outside_addresses(const std::string& address) {
  if (protocols::is_this_machine(address)) return {};
  if (address != "0.0.0.0" && address != "::") return {address};
  std::vector<std::string> all = interface_addresses(address == "::");
  // There is no interface yet.
  if (all.empty()) all.push_back(address);
  return all;
}

std::vector<std::string> exposures(const Config& config, const Ports& ports) {
  std::vector<std::string> lines;
  for (const auto& [name, port] : ports) {
    const Listener listener = listener_of(name, config);
    std::vector<std::string> places;
    for (const std::string& address : outside_addresses(listener.address)) {
      places.push_back(host_and_port(address, port));
    }
    if (places.empty()) continue;
    lines.push_back(fmt::format("{} is open to other machines at {}: {}", name,
                                fmt::join(places, ", "), listener.who));
  }
  return lines;
}

bool may_start_programs(const Config& config) {
  return config.web.enabled && config.web.control && !config.time.clients_pace &&
         config.web.programs.value_or(protocols::is_this_machine(config.web.address));
}

std::string host_and_port(const std::string& address, std::uint16_t port) {
  const bool v6 = address.find(':') != std::string::npos;
  return v6 ? fmt::format("[{}]:{}", address, port) : fmt::format("{}:{}", address, port);
}

}  // namespace aprsim::server
