#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>

#include <boost/asio/ip/address.hpp>

#include "world/base/rate_limit.hpp"

namespace aprsim::grpc_server {

/// Addresses that have exceeded limits recently. They are still served, because other clients may
/// share an address: new connections begin one after the other, with shorter timeouts. Thread: one
/// at a time.
class Backoff {
 public:
  using Clock = protocols::RateLimit::Clock;
  using Address = boost::asio::ip::address;
  static constexpr std::chrono::seconds kSpan{10};                ///< since the last offence
  static constexpr std::chrono::milliseconds kSpacing{50};        ///< of new connections
  static constexpr double kResetsPerS = 500, kResetBurst = 1000;  ///< of an address
  static constexpr std::size_t kMaxAddresses = 1024;              ///< remembered at once

  void offend(const Address& address, Clock::time_point now);
  /// Counts streams that an address has reset, on any connection: too many are an offence.
  void count_resets(const Address& address, std::uint64_t count, Clock::time_point now);
  [[nodiscard]] bool on(const Address& address, Clock::time_point now) const;
  /// Whether this new connection may begin; to be queried repeatedly until it may or has closed.
  [[nodiscard]] bool may_begin(const Address& address, const void* connection,
                               Clock::time_point now);
  void leave(const Address& address, const void* connection);

 private:
  struct Entry {
    Clock::time_point until{}, next_begin{}, forgotten{};
    std::deque<const void*> waiting;
    protocols::RateLimit resets{kResetsPerS, kResetBurst};
  };
  /// Null when the table is full.
  Entry* entry(const Address& address, Clock::time_point now);

  std::map<Address, Entry> entries_;
};

}  // namespace aprsim::grpc_server
