#include "protocols/access/peer_address.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>

namespace aprsim::protocols {
namespace {

constexpr std::size_t kNetworkBytes = 8;  // of an IPv6 address

std::string text_of(int family, const void* address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  return inet_ntop(family, address, text.data(), text.size()) ? text.data() : "";
}

}  // namespace

std::string client_address(std::string_view host) {
  const std::string text(host.substr(0, host.find('%')));  // without the scope
  in6_addr v6{};
  if (inet_pton(AF_INET6, text.c_str(), &v6) != 1) return text;
  if (IN6_IS_ADDR_LOOPBACK(&v6)) return "::1";
  if (IN6_IS_ADDR_V4MAPPED(&v6)) return text_of(AF_INET, &v6.s6_addr[12]);
  std::fill(std::begin(v6.s6_addr) + kNetworkBytes, std::end(v6.s6_addr), std::uint8_t{0});
  return text_of(AF_INET6, &v6) + "/64";
}

bool is_this_machine(std::string_view host) {
  const std::string address = client_address(host);
  return address.starts_with("127.") || address == "::1" || address == "localhost";
}

std::string_view host_of(std::string_view peer) {
  std::string_view host = peer.substr(0, peer.rfind(':'));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return host;
}

}  // namespace aprsim::protocols
