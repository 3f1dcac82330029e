#include "protocols/access_token.hpp"

#include "protocols/connection_places.hpp"

namespace aprsim::protocols {
namespace {

constexpr std::size_t kMaxAddresses = 4096;

/// Takes the same time wherever the texts differ.
bool equal_secrets(std::string_view given, std::string_view secret) {
  unsigned char different = given.size() == secret.size() ? 0 : 1;
  for (std::size_t i = 0; i < given.size(); ++i) {
    different |= static_cast<unsigned char>(given[i] ^ secret[i % secret.size()]);
  }
  return different == 0;
}

}  // namespace

AccessToken::Verdict AccessToken::check(std::string_view host, std::string_view given,
                                        Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  RateLimit& attempts = attempts_of(client_address(host), now);
  if (!attempts.has_room(now)) return Verdict::kTooManyAttempts;
  if (equal_secrets(given, token_)) return Verdict::kRight;
  (void)attempts.admit(now);
  return Verdict::kWrong;
}

RateLimit& AccessToken::attempts_of(const std::string& address, Clock::time_point now) {
  const auto found = attempts_.find(address);
  if (found != attempts_.end()) return found->second;
  if (attempts_.size() >= kMaxAddresses) {
    std::erase_if(attempts_, [now](const auto& entry) { return entry.second.is_full(now); });
  }
  if (attempts_.size() >= kMaxAddresses) return others_;
  return attempts_.emplace(address, RateLimit(kPerSecond, kBurst)).first->second;
}

}  // namespace aprsim::protocols
