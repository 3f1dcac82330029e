#pragma once

#include <string>
#include <vector>

#include "server/config/config.hpp"
#include "server/operations/ports_file.hpp"

namespace aprsim::server {

/// Numeric addresses at which other machines reach a listener bound to `address`; those of all
/// network interfaces for a wildcard address; empty = only this machine reaches it.
[[nodiscard]] std::vector<std::string> outside_addresses(const std::string& address);

/// A line for each listener that other machines reach, with address and permissions.
[[nodiscard]] std::vector<std::string> exposures(const Config& config, const Ports& ports);

/// Whether pages may start programs: as configured, else where only this machine reaches the page.
/// Never where pages may not command, nor in virtual time, which programs advance themselves.
[[nodiscard]] bool may_start_programs(const Config& config);

/// "ADDRESS:PORT", with an IPv6 address in brackets.
[[nodiscard]] std::string host_and_port(const std::string& address, std::uint16_t port);

}  // namespace aprsim::server
