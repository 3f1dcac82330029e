#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "protocols/access/role.hpp"
#include "world/base/result.hpp"

struct ssl_st;

namespace aprsim::modbus_server {

/// Rights by the role in a client's certificate: the Roles-to-Rights Rules Database of MODBUS/TCP
/// Security v3.6, section 8.4.
struct RoleRules {
  /// Key: the role's whole text. A role that is not here has no rights.
  std::map<std::string, protocols::Role> roles = {};
  protocols::Role no_role = protocols::Role::kNone;  ///< of a certificate without a role
};

/// Rights of one client: kView reads, kOperate also writes. Thread: any.
class ClientRights {
 public:
  /// A client without a certificate, of a port without TLS: it may send every request.
  ClientRights() = default;
  /// `identity` is its text for logs and audits.
  ClientRights(std::string identity, protocols::Role role)
      : identity_(std::move(identity)), role_(role) {}

  [[nodiscard]] const std::string& identity() const { return identity_; }
  [[nodiscard]] protocols::Role role() const { return role_; }
  /// The reason why a request with this function code gets exception 1; absent = it may be
  /// executed. The code decides alone: refused requests are not validated.
  [[nodiscard]] std::optional<std::string> refusal(std::uint8_t function) const;

 private:
  std::string identity_;
  protocols::Role role_ = protocols::Role::kAdmin;
};

/// Rights of the client whose handshake has finished, by its verified certificate. Errors: it has
/// none, a malformed role or several roles.
[[nodiscard]] Result<ClientRights> rights_of(ssl_st* connection, const RoleRules& rules);

}  // namespace aprsim::modbus_server
