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

/// SHA-256 of a salt and a secret. Secrets are 256 random bits, which cannot be guessed even with a
/// fast hash; so it may be computed at every call.
using Digest = std::array<std::uint8_t, 32>;
[[nodiscard]] Digest digest_of(std::string_view salt, std::string_view secret);

/// A token's entry, which holds its hash instead of the token.
struct TokenEntry {
  std::string name;
  Role role = Role::kNone;
  std::string salt;
  Digest digest{};
  std::optional<WallTime> expires = {};  ///< absent = never
};

/// A name in a client's certificate, common or alternative, and the role of its holder.
struct CertificateEntry {
  std::string name;
  Role role = Role::kNone;
};

/// Roles of callers by token, certificate and place.
struct AccessRules {
  std::vector<TokenEntry> tokens = {};
  std::vector<CertificateEntry> certificates = {};
  Role local = Role::kAdmin;  ///< callers on this machine without credentials
  Role others = Role::kView;  ///< callers on other machines without credentials
};

/// The identity in a client's verified certificate.
struct ClientCertificate {
  std::string subject;             ///< whole, as in RFC 2253
  std::vector<std::string> names;  ///< common name and alternative names
};

/// Credentials of a call.
struct Credentials {
  std::optional<std::string_view> token = {};
  std::shared_ptr<const ClientCertificate> certificate = {};  ///< null = none
};

/// A caller and its role.
struct Caller {
  enum class Problem : std::uint8_t { kNone, kWrongToken, kExpired, kTooManyAttempts };

  std::string name;  ///< "token NAME" or "certificate SUBJECT"; empty = no credentials
  Role role = Role::kNone;
  Problem problem = Problem::kNone;  ///< of the given token; the role is kNone then
  Digest digest{};                   ///< of the token, for still()
  std::shared_ptr<const ClientCertificate> certificate = {};
  bool local = false;

  /// For logs and audits: the name, or "no credentials".
  [[nodiscard]] std::string text() const { return name.empty() ? "no credentials" : name; }
};

/// The reason why a call is refused.
struct Refusal {
  enum class Kind : std::uint8_t { kUnauthenticated, kPermission, kTooManyAttempts };
  Kind kind;
  std::string message;  ///< names the role that is needed
};

struct AccessCounts {
  std::uint64_t unauthenticated = 0, permission = 0, too_many_attempts = 0;
};

/// Decides which role a caller has, over gRPC and on the page, and limits wrong tokens. A wrong
/// token of an address gets kTooManyAttempts after kBurst attempts with it, above kPerSecond; so
/// does each further one after kBurst different ones. One program's stale token thus limits no
/// other program behind its address. A right token is never limited. Thread: any.
class Access {
 public:
  using Clock = RateLimit::Clock;
  static constexpr double kBurst = 5, kPerSecond = 0.2;

  explicit Access(AccessRules rules)
      : rules_(std::make_shared<const AccessRules>(std::move(rules))) {}

  /// Sets new rules; still() applies them to earlier callers.
  void replace(AccessRules rules);

  /// The caller at this numeric host. With a wrong or expired token its role is kNone.
  [[nodiscard]] Caller identify(std::string_view host, const Credentials& credentials,
                                WallTime now = std::chrono::system_clock::now(),
                                Clock::time_point clock = Clock::now());
  /// The caller's role now: its token may have expired or been removed.
  [[nodiscard]] Role still(const Caller& caller,
                           WallTime now = std::chrono::system_clock::now()) const;
  /// Whether there are any tokens or certificates.
  [[nodiscard]] bool has_credentials() const;

  /// The reason why the caller may not make a call that needs this role; absent = it may. Counts
  /// refusals.
  [[nodiscard]] std::optional<Refusal> refusal(const Caller& caller, std::string_view call,
                                               Role needed);
  [[nodiscard]] AccessCounts counts() const;

 private:
  [[nodiscard]] std::shared_ptr<const AccessRules> rules() const;
  /// Wrong tokens of one address.
  struct Attempts {
    RateLimit guesses{kPerSecond, kBurst};  ///< different tokens
    std::map<Digest, RateLimit> repeated;   ///< by token, the latest ones

    [[nodiscard]] bool is_full(Clock::time_point now) const;
  };
  [[nodiscard]] bool admit(std::string_view host, std::string_view token, Clock::time_point now);
  /// Null when too many addresses are remembered.
  [[nodiscard]] Attempts* attempts_of(const std::string& address, Clock::time_point now);

  mutable std::mutex mutex_;
  std::shared_ptr<const AccessRules> rules_;
  std::map<std::string, Attempts> attempts_;  // by address with recent wrong tokens
  RateLimit others_{kPerSecond, kBurst};      // all other addresses, when the map is full
  AccessCounts counts_;
};

}  // namespace aprsim::protocols
