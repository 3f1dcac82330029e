#pragma once

#include <string>
#include <string_view>

namespace aprsim::protocols {

/// Whom a limit per address means by a numeric host: the IPv4 address, also of one mapped into
/// IPv6; of IPv6 the /64 network, all of which one machine may call its own.
[[nodiscard]] std::string client_address(std::string_view host);
/// Whether a numeric host or "localhost" is this machine's loopback.
[[nodiscard]] bool is_this_machine(std::string_view host);
/// The host of "ADDRESS:PORT" or "[ADDRESS]:PORT".
[[nodiscard]] std::string_view host_of(std::string_view peer);

}  // namespace aprsim::protocols
