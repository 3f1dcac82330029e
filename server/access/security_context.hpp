#pragma once

#include <memory>
#include <string>

#include "protocols/access/access.hpp"
#include "protocols/access/audit_log.hpp"
#include "protocols/net/tls.hpp"
#include "server/config/config.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::server {

/// Permissions, encryption and audit of gRPC, the page and Modbus Security. Thread: the owner's;
/// any for the objects that it points to.
class SecurityContext {
 public:
  /// Reads the files that the configuration names; throws std::runtime_error with key, file and
  /// cause where one is unusable. The source outlives it.
  SecurityContext(const Config& config, const api::SnapshotSource& source);

  /// Reads the files again and reopens the audit file. A file that cannot be read is logged; its
  /// earlier content stays in force.
  void reload();

 private:
  [[nodiscard]] Result<protocols::AccessRules> rules() const;

  const Config config_;

 public:
  const std::string program_token;  ///< of those that pages start; empty = they need none
  const std::shared_ptr<protocols::Access> access;
  const std::shared_ptr<protocols::Tls> grpc_tls, web_tls;  ///< null = not encrypted
  const std::shared_ptr<protocols::Tls> modbus_tls;         ///< null = no Modbus Security
  const std::unique_ptr<protocols::AuditLog> audit;         ///< null = none is kept
};

}  // namespace aprsim::server
