#include "protocols/grpc/http2/backoff.hpp"

#include <algorithm>

namespace aprsim::grpc_server {

void Backoff::offend(const Address& address, Clock::time_point now) {
  if (Entry* known = entry(address, now)) known->until = now + kSpan;
}

void Backoff::count_resets(const Address& address, std::uint64_t count, Clock::time_point now) {
  if (count == 0) return;
  Entry* known = entry(address, now);
  if (known == nullptr) return;
  bool all = true;
  for (; count > 0; --count) all = known->resets.admit(now) && all;
  if (!all) known->until = now + kSpan;
}

bool Backoff::on(const Address& address, Clock::time_point now) const {
  const auto known = entries_.find(address);
  return known != entries_.end() && now < known->second.until;
}

bool Backoff::may_begin(const Address& address, const void* connection, Clock::time_point now) {
  const auto known = entries_.find(address);
  if (known == entries_.end()) return true;
  auto& waiting = known->second.waiting;
  if (now >= known->second.until) {
    std::erase(waiting, connection);
    return true;
  }
  if (std::ranges::find(waiting, connection) == waiting.end()) waiting.push_back(connection);
  if (waiting.front() != connection || now < known->second.next_begin) return false;
  waiting.pop_front();
  known->second.next_begin = now + kSpacing;
  return true;
}

void Backoff::leave(const Address& address, const void* connection) {
  const auto known = entries_.find(address);
  if (known != entries_.end()) std::erase(known->second.waiting, connection);
}

Backoff::Entry* Backoff::entry(const Address& address, Clock::time_point now) {
  auto known = entries_.find(address);
  if (known == entries_.end()) {
    if (entries_.size() >= kMaxAddresses) {
      std::erase_if(entries_, [now](const auto& other) {
        return other.second.forgotten < now && other.second.waiting.empty();
      });
    }
    if (entries_.size() >= kMaxAddresses) return nullptr;
    known = entries_.try_emplace(address).first;
  }
  known->second.forgotten = now + kSpan;
  return &known->second;
}

}  // namespace aprsim::grpc_server
