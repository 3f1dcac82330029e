#pragma once

#include <string>
#include <string_view>

namespace aprsim::protocols {

/// The address by which limits count a numeric host: the IPv4 address, also where it is mapped into
/// IPv6; for IPv6 the /64 network, which one machine may own as a whole.
[[nodiscard]] std::string client_address(std::string_view host);
/// Whether a numeric host or "localhost" is this machine's loopback.
[[nodiscard]] bool is_this_machine(std::string_view host);
/// The host of "ADDRESS:PORT" or "[ADDRESS]:PORT".
[[nodiscard]] std::string_view host_of(std::string_view peer);

}  // namespace aprsim::protocols
