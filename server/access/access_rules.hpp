#pragma once

#include <memory>
#include <string>
#include <vector>

#include "protocols/access/access.hpp"
#include "protocols/net/tls.hpp"
#include "server/config/config.hpp"

namespace aprsim::server {

/// Reads the rules from the configuration and its access file. Errors name key and file.
[[nodiscard]] Result<protocols::AccessRules> access_rules(const Config& config);

/// Whether any token or certificate gives the right to command.
[[nodiscard]] bool asks_for_credentials(const Config& config);

/// Encryption of a listener; null = none. Errors name key and file.
[[nodiscard]] Result<std::shared_ptr<protocols::Tls>> make_tls(const TlsConfig& config,
                                                               protocols::Tls::Protocol protocol);

/// Encryption of Modbus Security, whose clients all show a certificate; null = there is none.
/// Errors name key and file.
[[nodiscard]] Result<std::shared_ptr<protocols::Tls>> make_modbus_tls(
    const ModbusTlsConfig& config);

/// The networks that a listener without credentials serves: those of the list, and this machine.
[[nodiscard]] std::vector<std::string> allowed_networks(std::vector<std::string> named);

}  // namespace aprsim::server
