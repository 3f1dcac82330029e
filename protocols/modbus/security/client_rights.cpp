#include "protocols/modbus/security/client_rights.hpp"

#include <memory>
#include <openssl/ssl.h>

#include <fmt/format.h>

#include "modbus/request.hpp"
#include "protocols/modbus/security/role_extension.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/net/tls.hpp"

namespace aprsim::modbus_server {
namespace {

using protocols::Role;

struct FreeCertificate {
  void operator()(X509* certificate) const { X509_free(certificate); }
};

}  // namespace

std::optional<std::string> ClientRights::refusal(std::uint8_t function) const {
  const Role needed = modbus::is_writing_function(function) ? Role::kOperate : Role::kView;
  if (role_ >= needed) return std::nullopt;
  return fmt::format("function {} needs the right {}; it has {}", function,
                     protocols::to_text(needed), protocols::to_text(role_));
}

Result<ClientRights> rights_of(ssl_st* connection, const RoleRules& rules) {
  const auto client = protocols::Tls::client_of(connection);
  const std::unique_ptr<X509, FreeCertificate> certificate(SSL_get1_peer_certificate(connection));
  if (!client || !certificate) {
    return fail(ErrorCode::kFailedPrecondition, "certificate", "it shows no certificate");
  }
  const auto role = role_of(certificate.get());
  if (!role) return tl::unexpected(role.error());
  const std::string identity = "certificate " + protocols::log_text(client->subject);
  if (!*role) return ClientRights(identity + ", no role", rules.no_role);
  const auto known = rules.roles.find(**role);
  return ClientRights(fmt::format("{}, role \"{}\"", identity, **role),
                      known == rules.roles.end() ? Role::kNone : known->second);
}

}  // namespace aprsim::modbus_server
