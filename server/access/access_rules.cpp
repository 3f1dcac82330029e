#include "server/access/access_rules.hpp"

#include <utility>

#include "server/access/access_file.hpp"

namespace aprsim::server {

bool asks_for_credentials(const Config& config) {
  return config.access.file.has_value() || !config.web.token.empty();
}

Result<protocols::AccessRules> access_rules(const Config& config) {
  using protocols::Role;
  protocols::AccessRules rules;
  if (config.access.file) {
    auto file = read_access_file(*config.access.file);
    if (!file) return tl::unexpected(file.error());
    rules.tokens = std::move(file->tokens);
    rules.certificates = std::move(file->certificates);
  }
  if (!config.web.token.empty()) {
    rules.tokens.push_back(
        entry_of(config.web.token, "of the configuration", Role::kAdmin, std::nullopt));
  }
  const Role anonymous = config.access.allow_anonymous_view ? Role::kView : Role::kNone;
  rules.others = config.access.insecure_control ? Role::kAdmin : anonymous;
  rules.local = config.access.insecure_control                        ? Role::kAdmin
                : asks_for_credentials(config) || !config.web.control ? anonymous
                                                                      : Role::kAdmin;
  return rules;
}

Result<std::shared_ptr<protocols::Tls>> make_tls(const TlsConfig& config,
                                                 protocols::Tls::Protocol protocol) {
  if (!config.certificate) return nullptr;
  return protocols::Tls::load({.certificate = *config.certificate,
                               .key = config.key.value_or(""),
                               .client_ca = config.client_ca.value_or(""),
                               .client_needed = config.client_needed},
                              protocol);
}

Result<std::shared_ptr<protocols::Tls>> make_modbus_tls(const ModbusTlsConfig& config) {
  if (!config.certificate) return nullptr;
  return protocols::Tls::load({.certificate = *config.certificate,
                               .key = config.key.value_or(""),
                               .client_ca = config.client_ca.value_or(""),
                               .client_needed = true,
                               .only_tls_1_3 = config.only_tls_1_3,
                               .section = "modbus.tls"},
                              protocols::Tls::Protocol::kModbus);
}

std::vector<std::string> allowed_networks(std::vector<std::string> named) {
  named.insert(named.end(), {"127.0.0.0/8", "::1"});
  return named;
}

}  // namespace aprsim::server
