#include "protocols/access/access.hpp"

#include <algorithm>
#include <ctime>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <stdexcept>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "protocols/access/peer_address.hpp"

namespace aprsim::protocols {
namespace {

constexpr std::size_t kMaxAddresses = 4096;
/// Wrong tokens remembered of one address.
constexpr std::size_t kMaxTokens = 16;

/// The entry of a token; null = none. Compares all bytes of all entries, so that the time it takes
/// reveals nothing.
const TokenEntry* find(const std::vector<TokenEntry>& tokens, std::string_view given) {
  const TokenEntry* found = nullptr;
  for (const TokenEntry& token : tokens) {
    const Digest digest = digest_of(token.salt, given);
    if (CRYPTO_memcmp(digest.data(), token.digest.data(), digest.size()) == 0) found = &token;
  }
  return found;
}

Role role_of(const AccessRules& rules, const ClientCertificate* certificate) {
  Role role = Role::kNone;
  if (certificate == nullptr) return role;
  for (const CertificateEntry& entry : rules.certificates) {
    if (std::ranges::find(certificate->names, entry.name) != certificate->names.end()) {
      role = std::max(role, entry.role);
    }
  }
  return role;
}

Role without_token(const AccessRules& rules, const Caller& caller) {
  return std::max(caller.local ? rules.local : rules.others,
                  role_of(rules, caller.certificate.get()));
}

}  // namespace

Digest digest_of(std::string_view salt, std::string_view secret) {
  Digest digest;
  unsigned int size = 0;
  const std::string text = std::string(salt) + std::string(secret);
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1 ||
      size != digest.size()) {
    throw std::runtime_error("OpenSSL cannot compute SHA-256");
  }
  return digest;
}

void Access::replace(AccessRules rules) {
  auto next = std::make_shared<const AccessRules>(std::move(rules));
  const std::lock_guard lock(mutex_);
  rules_ = std::move(next);
}

std::shared_ptr<const AccessRules> Access::rules() const {
  const std::lock_guard lock(mutex_);
  return rules_;
}

Caller Access::identify(std::string_view host, const Credentials& credentials, WallTime now,
                        Clock::time_point clock) {
  const auto rules = this->rules();
  Caller caller;
  caller.local = is_this_machine(host);
  caller.certificate = credentials.certificate;
  if (credentials.certificate) caller.name = "certificate " + credentials.certificate->subject;
  if (!credentials.token) {
    caller.role = without_token(*rules, caller);
    return caller;
  }
  const TokenEntry* token = find(rules->tokens, *credentials.token);
  if (token == nullptr) {
    const bool admitted = admit(host, *credentials.token, clock);
    caller.problem = admitted ? Caller::Problem::kWrongToken : Caller::Problem::kTooManyAttempts;
    return caller;
  }
  caller.name = "token " + token->name;
  if (token->expires && now >= *token->expires) {
    caller.problem = Caller::Problem::kExpired;
    return caller;
  }
  caller.digest = token->digest;
  caller.role = std::max(token->role, without_token(*rules, caller));
  return caller;
}

Role Access::still(const Caller& caller, WallTime now) const {
  if (caller.problem != Caller::Problem::kNone) return Role::kNone;
  const auto rules = this->rules();
  const Role least = without_token(*rules, caller);
  if (caller.digest == Digest{}) return least;
  for (const TokenEntry& token : rules->tokens) {
    if (token.digest != caller.digest) continue;
    return token.expires && now >= *token.expires ? least : std::max(token.role, least);
  }
  return least;
}

bool Access::has_credentials() const {
  const auto rules = this->rules();
  return !rules->tokens.empty() || !rules->certificates.empty();
}

std::optional<Refusal> Access::refusal(const Caller& caller, std::string_view call, Role needed) {
  using Kind = Refusal::Kind;
  const auto refuse = [this](Kind kind, std::string message) {
    const std::lock_guard lock(mutex_);
    ++(kind == Kind::kUnauthenticated ? counts_.unauthenticated
       : kind == Kind::kPermission    ? counts_.permission
                                      : counts_.too_many_attempts);
    return Refusal{kind, std::move(message)};
  };
  if (needed == Role::kNone) return std::nullopt;
  const std::string needs = fmt::format("{} needs the role {}", call, to_text(needed));
  switch (caller.problem) {
    case Caller::Problem::kTooManyAttempts:
      return refuse(Kind::kTooManyAttempts,
                    "authorization: too many wrong tokens from this address; wait a while");
    case Caller::Problem::kWrongToken:
      return refuse(Kind::kUnauthenticated,
                    "authorization: the token is not one of this daemon; " + needs);
    case Caller::Problem::kExpired:
      return refuse(Kind::kUnauthenticated,
                    fmt::format("authorization: {} has expired; {}", caller.name, needs));
    case Caller::Problem::kNone:
      break;
  }
  if (caller.role >= needed) return std::nullopt;
  if (!caller.name.empty()) {
    return refuse(Kind::kPermission, fmt::format("authorization: {}; {} has {}", needs, caller.name,
                                                 to_text(caller.role)));
  }
  if (has_credentials()) {
    return refuse(Kind::kUnauthenticated,
                  fmt::format("authorization: {}, by a token (metadata 'authorization: Bearer "
                              "TOKEN') or a client certificate",
                              needs));
  }
  return refuse(Kind::kPermission,
                fmt::format("authorization: {}; without credentials other machines may {} only "
                            "(access.file, or --insecure-control)",
                            needs, to_text(caller.role)));
}

AccessCounts Access::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

bool Access::Attempts::is_full(Clock::time_point now) const {
  return guesses.is_full(now) && std::ranges::all_of(repeated, [now](const auto& entry) {
           return entry.second.is_full(now);
         });
}

bool Access::admit(std::string_view host, std::string_view token, Clock::time_point now) {
  const Digest digest = digest_of("", token);
  const std::lock_guard lock(mutex_);
  Attempts* const attempts = attempts_of(client_address(host), now);
  if (attempts == nullptr) return others_.admit(now);
  auto& repeated = attempts->repeated;
  if (const auto known = repeated.find(digest); known != repeated.end()) {
    return known->second.admit(now);
  }
  if (!attempts->guesses.admit(now)) return false;
  if (repeated.size() >= kMaxTokens) {
    std::erase_if(repeated, [now](const auto& entry) { return entry.second.is_full(now); });
  }
  // A token that is not remembered counts as a new guess each time.
  if (repeated.size() < kMaxTokens) {
    (void)repeated.emplace(digest, RateLimit(kPerSecond, kBurst)).first->second.admit(now);
  }
  return true;
}

Access::Attempts* Access::attempts_of(const std::string& address, Clock::time_point now) {
  const auto found = attempts_.find(address);
  if (found != attempts_.end()) return &found->second;
  if (attempts_.size() >= kMaxAddresses) {
    std::erase_if(attempts_, [now](const auto& entry) { return entry.second.is_full(now); });
  }
  return attempts_.size() < kMaxAddresses ? &attempts_[address] : nullptr;
}

}  // namespace aprsim::protocols
