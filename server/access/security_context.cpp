#include "server/access/security_context.hpp"

#include <optional>
#include <stdexcept>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/access/access_file.hpp"
#include "server/access/access_rules.hpp"

namespace aprsim::server {
namespace {

template <typename T>
T value_or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

std::unique_ptr<protocols::AuditLog> open_audit(const AccessConfig& config,
                                                const api::SnapshotSource& source) {
  if (!config.audit_file) return nullptr;
  return value_or_throw(protocols::AuditLog::open(*config.audit_file, source));
}

/// Whether the operation succeeded; logs its error.
bool done_or_logged(const Result<void>& done) {
  if (!done) spdlog::error("not reloaded: {}", done.error().message);
  return done.has_value();
}

}  // namespace

SecurityContext::SecurityContext(const Config& config, const api::SnapshotSource& source)
    : config_(config),
      program_token(asks_for_credentials(config) ? random_token() : ""),
      access(std::make_shared<protocols::Access>(value_or_throw(rules()))),
      grpc_tls(value_or_throw(make_tls(config.tls, protocols::Tls::Protocol::kHttp2))),
      web_tls(value_or_throw(make_tls(config.tls, protocols::Tls::Protocol::kHttp1))),
      modbus_tls(value_or_throw(make_modbus_tls(config.modbus.tls))),
      audit(open_audit(config.access, source)) {}

void SecurityContext::reload() {
  bool good = true;
  if (auto next = rules()) {
    access->replace(std::move(*next));
  } else {
    good = done_or_logged(tl::unexpected(next.error()));
  }
  for (const auto& tls : {grpc_tls, web_tls, modbus_tls})
    good = (!tls || done_or_logged(tls->reload())) && good;
  good = (!audit || done_or_logged(audit->reopen())) && good;
  if (good) spdlog::info("tokens, certificates and the audit's file are reloaded");
}

Result<protocols::AccessRules> SecurityContext::rules() const {
  auto rules = access_rules(config_);
  if (rules && !program_token.empty()) {
    rules->tokens.push_back(
        entry_of(program_token, "programs of this daemon", protocols::Role::kAdmin, std::nullopt));
  }
  return rules;
}

}  // namespace aprsim::server
