#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocols/access/role.hpp"
#include "world/base/rate_limit.hpp"

namespace aprsim::protocols {

using WallTime = std::chrono::system_clock::time_point;

/// SHA-256 of a salt and then a secret. Secrets are 256 random bits, which nobody finds by trying
/// however quick the hash is; so it need not be a slow one, and may be computed at every call.
using Digest = std::array<std::uint8_t, 32>;
[[nodiscard]] Digest digest_of(std::string_view salt, std::string_view secret);

/// The record of a token: never the token itself.
struct TokenEntry {
  std::string name;
  Role role = Role::kNone;
  std::string salt;
  Digest digest{};
  std::optional<WallTime> expires = {};  ///< absent = never
};

/// A name in a client's certificate, its common name or an alternative one, and what its holder
/// may.
struct CertificateEntry {
  std::string name;
  Role role = Role::kNone;
};

/// Rules of access.
struct AccessRules {
  std::vector<TokenEntry> tokens = {};
  std::vector<CertificateEntry> certificates = {};
  Role local = Role::kAdmin;  ///< of callers on this machine without credentials
  Role others = Role::kView;  ///< of callers elsewhere without credentials
};

/// The identity that a client has proven by its certificate.
struct ClientCertificate {
  std::string subject;             ///< whole, as in RFC 2253
  std::vector<std::string> names;  ///< common name and alternative names
};

/// Credentials that came with a call.
struct Credentials {
  std::optional<std::string_view> token = {};
  std::shared_ptr<const ClientCertificate> certificate = {};  ///< null = none
};

/// The caller.
struct Caller {
  enum class Problem : std::uint8_t { kNone, kWrongToken, kExpired, kTooManyAttempts };

  std::string name;  ///< "token NAME" or "certificate SUBJECT"; empty = nobody in particular
  Role role = Role::kNone;
  Problem problem = Problem::kNone;  ///< with the token that was given; the role is kNone then
  Digest digest{};                   ///< of the token, for still()
  std::shared_ptr<const ClientCertificate> certificate = {};
  bool local = false;

  /// For logs and audits: the name, or "nobody" with the place.
  [[nodiscard]] std::string text() const { return name.empty() ? "no credentials" : name; }
};

/// Why a caller may not have what it asks for.
struct Refusal {
  enum class Kind : std::uint8_t { kUnauthenticated, kPermission, kTooManyAttempts };
  Kind kind;
  std::string message;  ///< names the role that is needed
};

struct AccessCounts {
  std::uint64_t unauthenticated = 0, permission = 0, too_many_attempts = 0;
};

/// Decides who may what, over gRPC and on the page, and who has guessed at tokens. After kBurst
/// wrong ones an address waits for each further attempt, also with a right one: else a guess would
/// be told from a token however often it is tried. Thread: any.
class Access {
 public:
  using Clock = RateLimit::Clock;
  static constexpr double kBurst = 5, kPerSecond = 0.2;

  explicit Access(AccessRules rules)
      : rules_(std::make_shared<const AccessRules>(std::move(rules))) {}

  /// New rules from now on; who was let in by the old ones is looked at again by still().
  void replace(AccessRules rules);

  /// The caller from this numeric host. A token that is wrong, or has expired, is worse than none.
  [[nodiscard]] Caller identify(std::string_view host, const Credentials& credentials,
                                WallTime now = std::chrono::system_clock::now(),
                                Clock::time_point clock = Clock::now());
  /// The same caller's role now: its token may have expired or been removed.
  [[nodiscard]] Role still(const Caller& caller,
                           WallTime now = std::chrono::system_clock::now()) const;
  /// Whether a caller without credentials could get more by a token.
  [[nodiscard]] bool has_credentials() const;

  /// Why the caller may not call what needs this role; absent = it may. Counts refusals.
  [[nodiscard]] std::optional<Refusal> refusal(const Caller& caller, std::string_view call,
                                               Role needed);
  [[nodiscard]] AccessCounts counts() const;

 private:
  [[nodiscard]] std::shared_ptr<const AccessRules> rules() const;
  [[nodiscard]] RateLimit& attempts_of(const std::string& address, Clock::time_point now);

  mutable std::mutex mutex_;
  std::shared_ptr<const AccessRules> rules_;
  std::map<std::string, RateLimit> attempts_;  // of the addresses that have failed of late
  RateLimit others_{kPerSecond, kBurst};       // all together, once those are too many
  AccessCounts counts_;
};

}  // namespace aprsim::protocols
